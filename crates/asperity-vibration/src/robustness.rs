//! Random machines under random friction: every motion must be complete, progress in time and obey the laws of
//! mechanics.

#[cfg(test)]
mod check;
#[cfg(test)]
mod draw;
#[cfg(test)]
mod reader;

#[cfg(test)]
mod tests {
    use crate::law::Exponential;
    use crate::tests::machine;
    use rayon::prelude::*;

    use super::super::{
        Count, Drive, Ensemble, EnsembleSettings, Oscillator, Trajectory, TrajectorySettings, VelocityLaw,
    };
    use super::check::{Checked, check};
    use super::draw::{Case, case};
    use crate::oracle::Oracle;
    use asperity_base::monitor::Silent;
    use asperity_process::{Cell, Steady};

    const SEED: u64 = 20_260_301;
    /// Number of machines between two checks of the time limit, and number of motions of each machine.
    const BLOCK: u64 = 64;
    const MOTIONS: u64 = 4;

    /// Totals over many motions.
    #[derive(Debug, Default)]
    struct Tally {
        cycles: u64,
        micro_slips: u64,
        events: u64,
        steps: u64,
        cells_read: u64,
        undecided: u64,
        touches: u64,
        lost: u64,
        worst: [f64; 10],
    }

    impl Tally {
        fn add(&mut self, seen: &Checked) {
            self.cycles += seen.slips.cycles;
            self.micro_slips += seen.slips.micro_slips;
            self.events += seen.events.len() as u64;
            self.steps += seen.steps;
            self.cells_read += seen.cells_read;
            self.undecided += seen.undecided;
            self.touches += seen.touches;
            self.lost += u64::from(seen.lost);
            for (worst, seen) in self.worst.iter_mut().zip(seen.worst) {
                *worst = worst.max(seen);
            }
        }
    }

    /// Checks the motions of machine `index`, and one of them through the public interface.
    fn motions(index: u64) -> Vec<Checked> {
        let case = case(SEED, index);
        let seen: Vec<Checked> = (0..MOTIONS).map(|motion| check(&case, SEED, MOTIONS * index + motion)).collect();
        let found = Trajectory::simulate(&case.oscillator, case.process.path(SEED, MOTIONS * index), &case.settings);
        match found {
            Ok(found) => {
                assert_eq!(found.events, seen[0].events);
                assert!(seen[0].undecided > 0 || found.slips == seen[0].slips, "{:?} {case:?}", found.slips);
            }
            Err(_) => assert!(seen[0].lost),
        }
        seen
    }

    #[test]
    #[ignore = "slow"]
    fn motions_of_random_machines_obey_the_equations() {
        let wanted = std::env::var("ASPERITY_CYCLES").map_or(3_000, |count| count.parse::<u64>().unwrap());
        let begun = std::time::Instant::now();
        let mut tally = Tally::default();
        let mut machines = 0;
        while tally.cycles < wanted {
            let block: Vec<_> = (machines..machines + BLOCK).into_par_iter().map(motions).collect();
            block.iter().flatten().for_each(|seen| tally.add(seen));
            machines += BLOCK;
        }
        println!("{machines} machines, {MOTIONS} motions each: {tally:?} in {:.1?}", begun.elapsed());
        // Cases that rounding decides are rare.
        assert!(10_000 * (tally.undecided + tally.touches) <= tally.events);
        // In most motions friction stays positive.
        assert!(10 * tally.lost < machines * MOTIONS);
    }

    #[test]
    fn a_slip_is_a_cycle_although_the_mass_turns_twice_in_a_step() {
        // Under a fast force this mass moves backwards between the start and the end of a step, at neither of which it
        // slows down.
        assert!(motions(37_455)[0].slips.cycles > 500);
    }

    /// Returns whether a slip conserves energy. It then returns just to the velocity of the belt, and rounding decides
    /// whether the mass sticks.
    fn grazes(oscillator: &Oscillator) -> bool {
        let law = oscillator.law();
        let keeps = oscillator.damping_ratio() == 0.0 && law.is_constant();
        keeps && law.kinetic() == oscillator.static_friction()
    }

    #[test]
    fn batches_and_single_simulations_of_random_machines_count_the_same() {
        let wanted = std::env::var("ASPERITY_CYCLES").map_or(60, |count| count.parse::<u64>().unwrap() / 100);
        let compared: Vec<[u64; 3]> = (0..wanted)
            .into_par_iter()
            .map(|index| {
                let case = case(SEED, index);
                if grazes(&case.oscillator) {
                    return [0; 3];
                }
                let oscillator = case.oscillator.with_forcing(None).unwrap();
                let duration = case.settings.duration.min(60.0);
                let settings = EnsembleSettings { least_valid_share: 0.0, ..EnsembleSettings::new(6, duration, SEED) };
                let Ok(found) = Ensemble::simulate(&oscillator, &case.process, &settings, &Silent) else {
                    return [0; 3];
                };
                let alone = TrajectorySettings { duration, start: None, drive: Drive::Distance };
                let mut sums = [0; 3];
                for i in 0..6 {
                    match Trajectory::simulate(&oscillator, case.process.path(SEED, i), &alone) {
                        Ok(found) => {
                            sums[0] += found.slips.cycles;
                            sums[1] += found.slips.micro_slips;
                        }
                        Err(_) => sums[2] += 1,
                    }
                }
                let failed = found.failures.len() as u64;
                let total =
                    |count: Count| if failed < 6 { (count.mean * (6 - failed) as f64).round() as u64 } else { 0 };
                assert_eq!([total(found.cycles), total(found.micro_slips), failed], sums, "{index} {case:?}");
                sums
            })
            .collect();
        let cycles: u64 = compared.iter().map(|sums| sums[0]).sum();
        assert!(cycles > 250);
    }

    /// Powers of two: products with them are exact.
    const FACTORS: [i32; 3] = [-33, -9, 9];

    #[test]
    fn motions_scale_with_friction_and_belt_velocity_to_the_last_bit() {
        let wanted = std::env::var("ASPERITY_CYCLES").map_or(16, |count| count.parse::<u64>().unwrap() / 200);
        let compared: Vec<[u64; 2]> = (0..wanted)
            .into_par_iter()
            .map(|index| {
                let case = case(SEED, index);
                let motion = |case: &Case| {
                    Trajectory::simulate(&case.oscillator, case.process.path(SEED, index), &case.settings).ok()
                };
                let ensemble = |case: &Case| {
                    let TrajectorySettings { duration, start, drive, .. } = case.settings;
                    let settings = EnsembleSettings { start, drive, ..EnsembleSettings::new(4, duration, SEED) };
                    let found = Ensemble::simulate(&case.oscillator, &case.process, &settings, &Silent).ok()?;
                    Some((found.cycles, found.micro_slips, found.stick_share, found.failures.len()))
                };
                let (alone, together) = (motion(&case), if index % 4 < 2 { ensemble(&case) } else { None });
                let mut sums = [0; 2];
                for power in FACTORS {
                    let factor = 2.0_f64.powi(power);
                    let Some(scaled) = case.scaled(factor) else { continue };
                    let mut found = motion(&scaled);
                    for event in found.iter_mut().flat_map(|found| &mut found.events) {
                        (event.displacement, event.sliding_distance) =
                            (event.displacement / factor, event.sliding_distance / factor);
                    }
                    assert_eq!(found, alone, "{index} times 2^{power}: {case:?}");
                    if index % 4 < 2 {
                        assert_eq!(ensemble(&scaled), together, "{index} times 2^{power}: {case:?}");
                    }
                    sums[0] += 1;
                    sums[1] += found.map_or(0, |found| found.events.len() as u64);
                }
                sums
            })
            .collect();
        let sum = |i: usize| compared.iter().map(|sums| sums[i]).sum::<u64>();
        println!("{} scaled motions, {} events", sum(0), sum(1));
        assert!(sum(0) > wanted && sum(1) > 10 * wanted);
    }

    #[test]
    fn a_late_steep_weakening_is_not_stepped_over() {
        // Belts of many Stribeck velocities: the whole weakening acts in the last few hundredths of a slip.
        for (belt_velocity, stribeck_velocity) in [(0.24, 0.012), (0.24, 0.003), (0.05, 0.002), (0.8, 0.005)] {
            let law = VelocityLaw::Exponential(Exponential { kinetic: 0.3, high_speed: 0.2, stribeck_velocity });
            let oscillator = machine(0.8, law, 0.01, belt_velocity);
            let settings = TrajectorySettings { duration: 60.0, start: None, drive: Drive::Distance };
            let series = Trajectory::simulate(&oscillator, Steady, &settings).unwrap().events;
            let steady = [Cell { end: 1e9, length: 1e9, left: 0.0, right: 0.0 }];
            let stages = Oracle::new(&oscillator, &steady, Drive::Distance, 2e-4).run(60.0);
            let stages: Vec<_> = stages.into_iter().filter(|event| event.1 <= 60.0).collect();
            assert!(
                series.len() == stages.len() && series.len() > 5,
                "{belt_velocity}: {} and {}",
                series.len(),
                stages.len()
            );
            for (a, (kind, tau, ..)) in series.iter().zip(stages) {
                assert!(a.kind == kind && (a.tau - tau).abs() < 1e-8, "{stribeck_velocity}: {a:?} and {tau}");
            }
        }
    }
}
