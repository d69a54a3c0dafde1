//! JSON Schema of `results.json`.

use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::Value;

use crate::companions::{CompanionCells, Companions};
use crate::{CampaignResults, Results, SCHEMA_VERSION, SurfaceStatistics};

/// Results of a run or of a campaign.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, reason = "only its schema is used")]
enum ResultsFile {
    Run(Box<Results>),
    Campaign(CampaignResults),
}

/// Returns the JSON Schema (draft 2020-12) of the `results.json` that this version writes, of a run or of a campaign.
///
/// Its descriptions are the documentation of the fields of [`Results`] and [`CampaignResults`]. Every object is closed, so an unknown key is invalid.
pub fn results_schema() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize().with_transform(tidy).with_transform(without_defaults);
    let mut schema = settings.into_generator().into_root_schema_for::<ResultsFile>();
    schema.insert("$id".into(), format!("urn:asperity:results:{SCHEMA_VERSION}").into());
    schema.insert("title".into(), "Results of an asperity study or campaign".into());
    schema
}

/// Joins the lines of descriptions, and removes the formats of numbers, which are names of Rust.
#[doc(hidden)]
pub fn tidy(schema: &mut Schema) {
    schema.remove("format");
    if let Some(Value::String(text)) = schema.get_mut("description") {
        let paragraphs: Vec<String> = text.split("\n\n").map(|paragraph| paragraph.replace('\n', " ")).collect();
        *text = paragraphs.join("\n\n");
    }
    transform_subschemas(&mut tidy, schema);
}

/// Removes the values that readers assume where earlier versions wrote none.
fn without_defaults(schema: &mut Schema) {
    schema.remove("default");
    transform_subschemas(&mut without_defaults, schema);
}

impl<T: CompanionCells> JsonSchema for Companions<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Companions".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let names = SurfaceStatistics::names();
        let patterns = T::ENDINGS.iter().map(|ending| {
            let mut cell = match *ending {
                "_interval" => generator.subschema_for::<Option<crate::Pair>>(),
                _ => generator.subschema_for::<Option<f64>>(),
            };
            let what = match *ending {
                "_interval" => "95 % interval of the statistic.",
                "_se" => "Standard error of the statistic.",
                "_within_std" => "Standard error of the statistic of a single scan.",
                "_between_std" => "Standard deviation of the statistic between places of the part.",
                _ => "Weighted mean of the statistic over the scans.",
            };
            cell.insert("description".into(), what.into());
            (format!("^({}){ending}$", names.join("|")), Value::from(cell))
        });
        json_schema!({ "type": "object", "patternProperties": patterns.collect::<serde_json::Map<_, _>>() })
    }
}
