//! The first of the random problems that `just validate` solves.

use asperity::contact::Solver;

#[path = "../examples/validate_contact/check.rs"]
#[allow(dead_code, reason = "the example's tables need more")]
mod check;
#[path = "../../asperity-contact/tests/contact/contact_check.rs"]
mod contact_check;
#[path = "../examples/validate_contact/problems.rs"]
#[allow(dead_code, reason = "the example's tables need more")]
mod problems;

#[test]
fn sixty_problems_of_the_validation_are_solved() {
    let solver = Solver::default();
    for number in 0..60 {
        let failure = check::Checked::of(number, solver).unwrap().failure(solver);
        assert!(failure.is_none(), "{failure:?}");
    }
}
