//! Judgement of machines, with or without the fluctuation of their friction.

use super::fluctuating::{self, NEGLIGIBLE_STD, Wanted};
use super::machines::{Machine, Machines};
use super::sampled::{Evaluated, Sampled};
use crate::friction::WindowFriction;
use crate::monitor::{Cancelled, Monitor};
use crate::stats::Interval;
use crate::study::check::VerdictStudy;
use crate::study::result::MachineModel;
use crate::study::sentence;

/// Factor of the duration after which the probability is computed again.
pub(super) const LATER: usize = 4;

/// Returns whether a standard deviation of friction is negligible.
pub(super) fn is_negligible(window: &WindowFriction, std: f64) -> bool {
    std < NEGLIGIBLE_STD * window.mean
}

/// How machines are judged: with the fluctuation of friction, for a duration.
pub(super) struct Judge<'a> {
    threshold: f64,
    pub(super) duration_s: f64,
    pub(super) is_coupled: bool,
    pub(super) friction_fluctuates: bool,
    pub(super) one_window_fluctuates: bool,
    pub(super) seed: u64,
    pub(super) monitor: &'a dyn Monitor,
}

impl<'a> Judge<'a> {
    pub(super) fn new(
        study: &VerdictStudy,
        window: &WindowFriction,
        nominal: &Machine,
        seed: u64,
        monitor: &'a dyn Monitor,
    ) -> Self {
        let is_coupled = nominal.dynamics.model() == MachineModel::ModeCoupling;
        let upscaled_std = nominal.window.upscaled_std(nominal.inputs.upscaling);
        Self {
            threshold: study.threshold,
            duration_s: study.duration_s,
            is_coupled,
            friction_fluctuates: !is_negligible(&nominal.window, upscaled_std),
            one_window_fluctuates: !is_negligible(window, window.std) && !is_coupled,
            seed,
            monitor,
        }
    }

    /// Returns whether the fluctuation of friction counts.
    pub(super) fn fluctuates(&self) -> bool {
        self.friction_fluctuates && !self.is_coupled
    }

    pub(super) fn assumptions(&self) -> Vec<String> {
        let mut assumptions = Vec::new();
        if self.is_coupled {
            assumptions.push(
                "The verdict on mode coupling counts a machine as vibrating if its steady sliding is unstable at the mean friction \
                 coefficient, however its motion begins; the margin is μ_c − μ."
                    .into(),
            );
        }
        if self.is_coupled && self.friction_fluctuates {
            assumptions.push("The verdict on mode coupling leaves out the fluctuation of friction.".into());
        }
        assumptions
    }

    /// Returns the answer of machine number `index`, with trajectories until the fraction of the time is above or below all `levels`.
    pub(super) fn evaluate(&self, machine: &Machine, index: usize, levels: &[f64]) -> Result<Evaluated, String> {
        self.evaluate_for(machine, index, Wanted { duration_s: self.duration_s, levels })
    }

    fn evaluate_for(&self, machine: &Machine, index: usize, wanted: Wanted<'_>) -> Result<Evaluated, String> {
        let evaluated = Evaluated::constant_friction(machine)?;
        let found = fluctuating::fraction(machine, wanted, self.seed.wrapping_add(index as u64), self.monitor)?;
        Ok(found.map_or(evaluated, |fraction| evaluated.with_fraction(fraction, self.threshold)))
    }

    /// Returns a warning if the probability after a longer time is outside of its interval.
    pub(super) fn changes_later(
        &self,
        machines: &Machines<'_>,
        sampled: &Sampled,
        interval: Interval,
    ) -> Result<Option<String>, Cancelled> {
        if !self.fluctuates() {
            return Ok(None);
        }
        let wanted = Wanted { duration_s: LATER as f64 * self.duration_s, levels: &[self.threshold] };
        let vibrates = |machine: &Machine, index| Ok(self.evaluate_for(machine, index, wanted)?.vibrates);
        let later = sampled.later(machines, &vibrates, self.monitor)?;
        Ok((!interval.contains(later)).then(|| {
            let percent = sentence::digits(100.0 * later);
            format!("the probability depends on the duration: after four times as long it is {percent} %")
        }))
    }
}
