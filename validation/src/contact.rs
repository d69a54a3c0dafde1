//! Random contact problems, and checks of their solutions.

mod check;
#[path = "../../crates/asperity-contact/tests/contact/contact_check.rs"]
mod contact_check;
mod problems;

pub use check::CheckedSolution;
pub use problems::{RandomProblem, SurfaceKind, random_problem, rough};

#[cfg(test)]
mod tests {
    use asperity::contact::Solver;

    use super::*;

    #[test]
    fn the_first_sixty_problems_are_solved() {
        let solver = Solver::default();
        for number in 0..60 {
            let failure = CheckedSolution::new(number, solver).unwrap().failure(solver);
            assert!(failure.is_none(), "{failure:?}");
        }
    }
}
