//! The back end: looks back on the drive in what time the other tasks leave.

use crate::look_backs::LookBacks;

/// Looks back for the work of one step whenever the estimator lends the back end. Every other task goes before this one.
pub async fn look_back(look_backs: &LookBacks) -> ! {
    loop {
        let back_end = look_backs.lent().await;
        back_end::look_back(back_end);
        look_backs.give_back(back_end);
    }
}
