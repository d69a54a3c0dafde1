//! Imposing a distribution on normal variables.

crate::choice! {
    /// Correlation of a normal process or field that gets another distribution by pointwise translation z = F⁻¹(Φ(g)).
    #[derive(Default)]
    pub enum TranslationKind: "translation" {
        /// The normal variables have the wanted correlation, which the translation changes a little (as in the paper).
        #[default]
        Plain = "plain",
        /// The correlation of the normal variables is changed beforehand, so that the values have the wanted one.
        Corrected = "corrected",
    }
}
