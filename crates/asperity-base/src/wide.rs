//! The widest vector registers of the machine, found at run time.
//!
//! Builds are portable, so loops are compiled for the oldest processors. Those that matter are compiled for newer ones
//! as well and chosen here. Sums are written with a fixed number of lanes, and products are not fused with sums, so
//! that a loop gives the same bits on every machine.

use std::marker::PhantomData;

/// A loop that is worth wide registers.
///
/// `run` has to be `#[inline(always)]`: only what is inlined into its caller is compiled for them. That is why this is
/// no closure, which would be compiled apart.
#[doc(hidden)]
pub trait Kernel<A> {
    /// What it computes.
    type Output;

    /// Runs the loop.
    fn run(arguments: A) -> Self::Output;
}

/// Runs `K` compiled for the registers that the machine has.
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
