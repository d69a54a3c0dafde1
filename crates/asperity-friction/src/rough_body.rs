//! Choice of the rough body of a sliding contact.

use asperity_base::choice;

choice! {
    /// Rough body of a sliding contact.
    ///
    /// Friction fluctuates along the path only if new contacts form on the way. A rough slider on a smooth track carries its
    /// contacts along, so the friction coefficient of a part is constant and parts differ by a constant.
    #[derive(Default)]
    pub enum RoughBody: "rough body" {
        /// A smooth slider passes over a rough track: friction fluctuates along the path.
        #[default]
        Track = "track",
        /// A rough slider on a smooth track carries its contacts along: friction is constant for each part.
        Slider = "slider",
        /// Both: friction differs from part to part and fluctuates along the path.
        Both = "both",
    }
}
