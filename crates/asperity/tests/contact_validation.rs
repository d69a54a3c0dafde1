//! The first of the random problems that `just validate` solves.

use asperity::contact::Solver;

#[path = "../../../validation/src/bin/validate_contact/check.rs"]
#[allow(dead_code, reason = "the program's tables need more")]
mod check;
mod contact_check;
#[path = "../../../validation/src/bin/validate_contact/problems.rs"]
#[allow(dead_code, reason = "the program's tables need more")]
mod problems;

#[test]
fn sixty_problems_of_the_validation_are_solved() {
    let solver = Solver::default();
    for number in 0..60 {
        let failure = check::Checked::of(number, solver).unwrap().failure(solver);
        assert!(failure.is_none(), "{failure:?}");
    }
}
