//! The first of the random problems that `just validate` solves.

use asperity::contact::Solver;

use crate::check::Checked;

#[test]
fn sixty_problems_of_the_validation_are_solved() {
    let solver = Solver::default();
    for number in 0..60 {
        let failure = Checked::of(number, solver).unwrap().failure(solver);
        assert!(failure.is_none(), "{failure:?}");
    }
}
