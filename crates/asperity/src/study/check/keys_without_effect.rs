//! Keys of a study that have no effect.

use asperity_results::keys::KEYS;
use toml::{Table, Value};

use crate::map::BoundaryKind;
use crate::pressure::PressureMethod;
use crate::study::file::{CounterfaceSection, StudyFile, SurfaceSection};
use crate::surface::SurfaceGenerator;

impl StudyFile {
    /// Returns a sentence for each stated key that has no effect.
    pub fn keys_without_effect(&self) -> Vec<String> {
        let mut keys: Vec<String> =
            self.surface.iter().flat_map(|surface| surface.keys_without_effect("surface")).collect();
        let expanded = |surface: &&SurfaceSection| surface.generator == SurfaceGenerator::KarhunenLoeve;
        let modes = self.surface.as_ref().filter(|surface| !expanded(surface)).and_then(|surface| surface.modes);
        keys.extend(modes.map(|_| "[surface] modes has no effect without the generator karhunen_loeve".to_owned()));
        if let (Some(counterface), Some(surface)) = (&self.counterface, &self.surface) {
            keys.extend(counterface.keys_without_effect(surface));
        }
        let body = self.surface.as_ref().and_then(|surface| surface.body).filter(|_| self.friction.is_none());
        keys.extend(body.map(|_| "[surface] body has no effect without [friction]".to_owned()));
        if let Some(surface) = self.surface.as_ref().filter(|_| self.pressure.is_none() && self.friction.is_some()) {
            let patches_only = |key: &str| format!("[surface] {key} has no effect without [pressure]");
            keys.extend((!surface.mean_mode).then(|| patches_only("mean_mode")));
            keys.extend(surface.rescale.map(|_| patches_only("rescale")));
        }
        let periodic_only = |section: &str| format!("[{section}] mean_compliance has no effect on the free boundary");
        if self.pressure.as_ref().is_some_and(|p| p.boundary == BoundaryKind::Free && p.mean_compliance.is_some()) {
            keys.push(periodic_only("pressure"));
        }
        if self
            .pressure
            .as_ref()
            .is_some_and(|p| p.reference_samples.is_some() && !PressureMethod::are_compared(&p.methods))
        {
            keys.push(
                "[pressure] reference_samples has no effect unless `methods` lists others than \"default\"".into(),
            );
        }
        if self.friction.as_ref().is_some_and(|f| f.boundary == BoundaryKind::Free && f.mean_compliance.is_some()) {
            keys.push(periodic_only("friction"));
        }
        if let Some(friction) = &self.friction {
            let unmet = self.unmet("friction", "law", friction.law.name());
            keys.extend(
                unmet.map(|(key, law)| format!("[friction] {} has no effect without law = \"{law}\"", key.name)),
            );
        }
        if let Some(friction) = self.friction.as_ref().filter(|f| !f.law.is_sheared())
            && self.material.as_ref().is_some_and(|m| m.shear_strength.is_some())
        {
            keys.push(format!("[material] shear_strength has no effect with law = \"{}\"", friction.law));
        }
        keys
    }
}

impl CounterfaceSection {
    /// Returns a sentence for each stated key that has no effect.
    fn keys_without_effect(&self, surface: &SurfaceSection) -> Vec<String> {
        if *self == Self::default() {
            return vec![
                "[counterface] has no effect: it states nothing, and a smooth rigid body is the default".to_owned(),
            ];
        }
        let mut keys = self.roughness(surface).keys_without_effect("counterface");
        let without_file = self.level.filter(|_| self.file.is_none());
        keys.extend(without_file.map(|_| "[counterface] level has no effect without `file`".to_owned()));
        let smooth = self.translation.filter(|_| self.roughness_key().is_none());
        keys.extend(smooth.map(|_| "[counterface] translation has no effect on a smooth body".to_owned()));
        keys
    }
}

impl SurfaceSection {
    /// Returns a sentence for each stated key of `section` that has no effect.
    pub(in crate::study) fn keys_without_effect(&self, section: &str) -> Vec<String> {
        let fractal = self.generator == SurfaceGenerator::WeierstrassMandelbrot;
        let measured = self.covariance.is_of_the_scan();
        let stated = Table::try_from(self).unwrap_or_default();
        let unmet = KEYS.iter().filter(|key| key.section == "surface" && stated.contains_key(key.name));
        let unmet = unmet.filter_map(|key| {
            let (name, word) = key.needs?;
            let is_met = stated.get(name).and_then(Value::as_str) == Some(word);
            (!is_met).then(|| format!("[{section}] {} has no effect without {name} = \"{word}\"", key.name))
        });
        let others = [
            ("correlation_length", self.correlation_length.is_some() && measured, "with a measured covariance"),
            ("cut_off", self.cut_off.is_some() && fractal, "with the generator weierstrass_mandelbrot"),
            ("channel", self.channel.is_some() && self.file.is_none(), "without `file`"),
            ("pixel_size", self.pixel_size.is_some() && self.file.is_none(), "without `file`"),
            ("height_unit", self.height_unit.is_some() && self.file.is_none(), "without `file`"),
            ("decimal", self.decimal.is_some() && self.file.is_none(), "without `file`"),
            ("isotropic", self.isotropic && self.file.is_none(), "without `file`"),
            ("outliers", self.outliers.is_some() && self.file.is_none(), "without `file`"),
            ("s_filter", self.s_filter.is_some() && self.file.is_none(), "without `file`"),
            ("l_filter", self.l_filter.is_some() && self.file.is_none(), "without `file`"),
            ("robust_filter", self.robust_filter && self.l_filter.is_none(), "without `l_filter`"),
        ]
        .into_iter()
        .filter(|(_, unused, _)| *unused)
        .map(|(key, _, why)| format!("[{section}] {key} has no effect {why}"));
        unmet.chain(others).collect()
    }
}
