//! Runtime dispatch to the widest vector registers.
//!
//! Builds are portable, so loops are compiled for the oldest processors. Time-critical loops are also compiled for
//! newer ones and selected here at run time. Sums have a fixed number of partial sums and products are not fused with
//! sums, so a loop gives the same bits on every machine.

use std::marker::PhantomData;

/// Loop compiled for several register widths.
///
/// `run` has to be `#[inline(always)]`, since only inlined code is compiled for the target features. A closure would be
/// compiled separately, hence the trait.
#[doc(hidden)]
pub trait Kernel<A> {
    /// Result of the loop.
    type Output;

    /// Runs the loop.
    fn run(arguments: A) -> Self::Output;
}

/// Runs `K` compiled for the widest available registers.
#[inline(always)]
#[doc(hidden)]
pub fn wide<K: Kernel<A>, A>(arguments: A) -> K::Output {
    pulp::Arch::new().dispatch(Call { arguments, kernel: PhantomData::<K> })
}

struct Call<K, A> {
    arguments: A,
    kernel: PhantomData<K>,
}

impl<K: Kernel<A>, A> pulp::NullaryFnOnce for Call<K, A> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        K::run(self.arguments)
    }
}
