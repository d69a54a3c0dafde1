//! Calls for fuzz targets, without the types of a browser.

use serde_json::Value;

use crate::answer::{Answer, Failure};
use crate::{Surface, oscillator};

/// Largest map that is drawn or described, in points: a target is to be called often.
const LARGEST_MAP: u64 = 1 << 10;

/// Answers a request of a page, about a scan if its settings are followed by one.
pub fn answer(name: &str, request: &str, scan: Option<&[u8]>) {
    // The answer or the error is the result.
    let _ = match (name, scan) {
        ("machine", _) => oscillator::scaled(request),
        ("cycle", _) => oscillator::motion(request, 2),
        ("limits", _) => oscillator::ends_of_vibration(request),
        ("surface", _) => stated(request),
        ("settings", Some(scan)) => described(scan, request),
        _ => return,
    };
}

fn stated(settings: &str) -> Result<Answer, Failure> {
    let value: Value = serde_json::from_str(settings)?;
    let points = value["points"].as_array().into_iter().flatten().map(|n| n.as_u64().unwrap_or(u64::MAX));
    if points.fold(1_u64, u64::saturating_mul) > LARGEST_MAP {
        return Err(Failure("large".into()));
    }
    Surface::from_settings(settings)?.description(1)
}

fn described(scan: &[u8], settings: &str) -> Result<Answer, Failure> {
    let surface = Surface::from_scan(scan, "scan".into(), settings)?;
    surface.radial()?;
    surface.description(1)
}
