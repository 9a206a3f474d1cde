//! What there is to set, read from the JSON Schemas of lights and techniques. No technique is known here by name.

use antumbra::techniques::{Techniques, schemars};
use antumbra_stage::shot::{ShotLight, tidy};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};

/// The schemas of lights and of all techniques of a list.
#[derive(Debug)]
pub struct Schemas {
    defs: Map<String, Value>,
    light: Value,
    techniques: Vec<(&'static str, Option<Value>)>,
}

/// The form of a value, which decides its widget.
#[derive(Debug)]
pub enum Form<'a> {
    /// True or false.
    Flag,
    /// A number within bounds.
    Number(Bounds),
    /// Text, such as a path.
    Text,
    /// A list of a fixed length, each entry of the same schema.
    Row(usize, &'a Value),
    /// A list of texts.
    Texts,
    /// An object with these properties.
    Object(&'a Map<String, Value>),
    /// One of several forms. Two of the same name are two ways to write the same.
    Choice(Vec<Branch<'a>>),
    /// A value of a schema, or none.
    Optional(&'a Value),
    /// A form without a widget; it is edited as JSON text.
    Other,
}

/// The bounds of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Smallest number.
    pub least: Option<f64>,
    /// Largest number.
    pub most: Option<f64>,
    /// Whether the number is an integer.
    pub whole: bool,
}

/// One of several forms of a value.
#[derive(Debug)]
pub struct Branch<'a> {
    /// Name in the menu.
    pub name: String,
    /// What it means.
    pub help: &'a str,
    /// The schema of the branch itself.
    pub schema: &'a Value,
    /// How the value looks.
    pub kind: BranchKind<'a>,
}

/// How a value of a branch looks.
#[derive(Debug)]
pub enum BranchKind<'a> {
    /// It is this text or this number.
    Exactly(&'a Value),
    /// It is an object with one key, whose value has this schema.
    Keyed(&'a str, &'a Value),
    /// It is a value of the branch's schema.
    Plain,
}

impl Schemas {
    /// Collects the schemas of a list of techniques.
    pub fn of(techniques: &Techniques) -> Self {
        let mut generator = SchemaSettings::draft2020_12().into_generator();
        let light = ShotLight::json_schema(&mut generator).to_value();
        let rows = techniques.rows().iter();
        let techniques: Vec<(&str, Option<Value>)> = rows
            .map(|row| {
                let schema = row.schema(&mut generator);
                (row.name(), schema.map(schemars::Schema::to_value))
            })
            .collect();
        let mut all = Self {
            defs: generator.take_definitions(true),
            light,
            techniques,
        };
        all.defs.values_mut().for_each(tidy);
        tidy(&mut all.light);
        all.techniques
            .iter_mut()
            .filter_map(|(_, schema)| schema.as_mut())
            .for_each(tidy);
        all
    }

    /// Names of the techniques, in the order of the list.
    pub fn technique_names(&self) -> impl Iterator<Item = &'static str> {
        self.techniques.iter().map(|(name, _)| *name)
    }

    /// Returns the schema of a technique's settings; `None` if the technique describes none.
    pub fn technique(&self, name: &str) -> Option<&Value> {
        let known = self.techniques.iter().find(|(known, _)| *known == name)?;
        known.1.as_ref()
    }

    /// Returns what a technique says about itself.
    pub fn about(&self, name: &str) -> String {
        self.technique(name).map_or_else(String::new, help)
    }

    /// Returns the schema of a kind of light.
    pub fn light(&self, kind: &str) -> Option<&Value> {
        let kinds = self.light.get("oneOf")?.as_array()?;
        kinds
            .iter()
            .find(|schema| schema["properties"]["kind"]["const"] == json!(kind))
    }

    /// Returns the names of all kinds of light.
    pub fn light_kinds(&self) -> Vec<&str> {
        let kinds = self.light.get("oneOf").and_then(Value::as_array);
        kinds
            .into_iter()
            .flatten()
            .filter_map(|schema| schema.pointer("/properties/kind/const")?.as_str())
            .collect()
    }

    /// Whether a schema is that of a type of this name.
    pub fn is_type(&self, name: &str) -> bool {
        self.defs.contains_key(name)
    }

    /// Follows the reference of a schema.
    pub fn resolve<'a>(&'a self, schema: &'a Value) -> &'a Value {
        let mut schema = schema;
        // Definitions are not nested deeper than this; a circle ends here.
        for _ in 0..8 {
            let Some(name) = definition(schema) else { break };
            let Some(next) = self.defs.get(name) else { break };
            schema = next;
        }
        schema
    }

    /// Returns the form of a schema.
    pub fn form<'a>(&'a self, schema: &'a Value) -> Form<'a> {
        let schema = self.resolve(schema);
        if let Some(branches) = branches(schema) {
            return self.choice(branches);
        }
        if let Some(values) = schema.get("enum").and_then(Value::as_array) {
            return Form::Choice(values.iter().map(|value| exactly(value, schema)).collect());
        }
        let (kind, optional) = type_of(schema);
        if optional {
            return Form::Optional(schema);
        }
        self.plain(kind, schema)
    }

    /// Returns the form of a schema, not minding that its value may be missing.
    pub fn form_of_some<'a>(&'a self, schema: &'a Value) -> Form<'a> {
        let schema = self.resolve(schema);
        match self.form(schema) {
            Form::Optional(inner) if std::ptr::eq(inner, schema) => self.plain(type_of(schema).0, schema),
            Form::Optional(inner) => self.form_of_some(inner),
            form => form,
        }
    }

    fn plain<'a>(&'a self, kind: &str, schema: &'a Value) -> Form<'a> {
        let bound = |key: &str| schema.get(key).and_then(Value::as_f64);
        match kind {
            "boolean" => Form::Flag,
            "number" | "integer" => Form::Number(Bounds {
                least: bound("minimum"),
                most: bound("maximum"),
                whole: kind == "integer",
            }),
            "string" => Form::Text,
            "object" => schema
                .get("properties")
                .and_then(Value::as_object)
                .map_or(Form::Other, Form::Object),
            "array" => self.list(schema),
            _ => Form::Other,
        }
    }

    fn list<'a>(&'a self, schema: &'a Value) -> Form<'a> {
        let Some(items) = schema.get("items") else {
            return Form::Other;
        };
        let length = |key: &str| schema.get(key).and_then(Value::as_u64);
        match (length("minItems"), length("maxItems")) {
            (Some(least), Some(most)) if least == most && most <= 4 => Form::Row(most as usize, items),
            _ if type_of(self.resolve(items)).0 == "string" => Form::Texts,
            _ => Form::Other,
        }
    }

    /// Returns the form of alternatives. An alternative that is `null` makes the others optional.
    fn choice<'a>(&'a self, all: &'a [Value]) -> Form<'a> {
        let is_null = |schema: &&Value| type_of(schema).0 == "null";
        let mut some = all.iter().filter(|schema| !is_null(schema));
        if let (Some(only), None, true) = (
            some.next(),
            some.next(),
            all.iter().any(|schema| is_null(&schema)),
        ) {
            return Form::Optional(only);
        }
        let mut known = Vec::new();
        for schema in all {
            self.add_branches(schema, &mut known);
        }
        Form::Choice(known)
    }

    fn add_branches<'a>(&'a self, schema: &'a Value, to: &mut Vec<Branch<'a>>) {
        let schema = self.resolve(schema);
        if let Some(inner) = branches(schema) {
            inner.iter().for_each(|schema| self.add_branches(schema, to));
            return;
        }
        if let Some(value) = schema.get("const") {
            to.push(exactly(value, schema));
            return;
        }
        if let Some(values) = schema.get("enum").and_then(Value::as_array) {
            to.extend(values.iter().map(|value| exactly(value, schema)));
            return;
        }
        let keyed = schema
            .get("properties")
            .and_then(Value::as_object)
            .filter(|properties| properties.len() == 1)
            .and_then(|properties| properties.iter().next());
        let required = |key: &str| {
            let keys = schema.get("required").and_then(Value::as_array);
            keys.is_some_and(|keys| keys.iter().any(|known| known == key))
        };
        let (name, kind) = match keyed {
            Some((key, inner)) if required(key) => (key.clone(), BranchKind::Keyed(key, inner)),
            _ => (plain_name(schema), BranchKind::Plain),
        };
        to.push(Branch {
            name,
            help: description(schema),
            schema,
            kind,
        });
    }

    /// Returns the index of the branch that a value is of.
    pub fn branch_of(&self, branches: &[Branch], value: &Value) -> Option<usize> {
        let exact = branches.iter().position(|branch| match branch.kind {
            BranchKind::Exactly(only) => value == only,
            BranchKind::Keyed(key, _) => value.get(key).is_some(),
            BranchKind::Plain => match type_of(branch.schema).0 {
                "number" | "integer" => value.is_number(),
                "boolean" => value.is_boolean(),
                "string" => value.is_string(),
                "array" => value.is_array(),
                "object" => value
                    .as_object()
                    .is_some_and(|object| has_keys_of(object, branch.schema)),
                _ => false,
            },
        });
        // An object with a key too few or too many is shown as one, so that it can be mended.
        let is_object = |branch: &Branch| {
            matches!(branch.kind, BranchKind::Plain) && type_of(branch.schema).0 == "object"
        };
        let similar = || branches.iter().position(is_object).filter(|_| value.is_object());
        exact.or_else(similar)
    }

    /// Returns the first value of a branch.
    pub fn first_of(&self, branch: &Branch) -> Value {
        match branch.kind {
            BranchKind::Exactly(value) => value.clone(),
            BranchKind::Keyed(key, inner) => json!({ key: self.first(inner) }),
            BranchKind::Plain => self.first(branch.schema),
        }
    }

    /// Returns the value that a setting begins with: its default, its example, or what its bounds allow.
    pub fn first(&self, schema: &Value) -> Value {
        let own = schema.get("default").filter(|default| !default.is_null());
        let example = schema.pointer("/examples/0");
        if let Some(value) = own.or(example) {
            return value.clone();
        }
        let schema = self.resolve(schema);
        if let Some(example) = schema.pointer("/examples/0") {
            return example.clone();
        }
        match self.form_of_some(schema) {
            Form::Flag => json!(false),
            Form::Number(bounds) => {
                let least = bounds.least.unwrap_or(0.0);
                let value = bounds
                    .most
                    .map_or(least.max(1.0), |most| least.max(1.0).min(most));
                if bounds.whole {
                    json!(value as i64)
                } else {
                    json!(value)
                }
            }
            Form::Text => json!(""),
            Form::Texts => json!([]),
            Form::Row(count, item) => Value::Array(vec![self.first(item); count]),
            Form::Object(properties) => {
                // Anything else has a default.
                let required = schema.get("required").and_then(Value::as_array);
                let keys = required.into_iter().flatten().filter_map(Value::as_str);
                let pairs = keys.map(|key| (key.to_owned(), self.first(&properties[key])));
                Value::Object(pairs.collect())
            }
            Form::Choice(branches) => branches
                .first()
                .map_or(Value::Null, |branch| self.first_of(branch)),
            Form::Optional(_) | Form::Other => Value::Null,
        }
    }
}

/// Returns the name of the definition that a schema refers to.
pub fn definition(schema: &Value) -> Option<&str> {
    schema.get("$ref")?.as_str()?.rsplit('/').next()
}

fn branches(schema: &Value) -> Option<&[Value]> {
    let all = schema.get("oneOf").or_else(|| schema.get("anyOf"))?;
    all.as_array().map(Vec::as_slice)
}

fn exactly<'a>(value: &'a Value, schema: &'a Value) -> Branch<'a> {
    Branch {
        name: value.as_str().map_or_else(|| value.to_string(), str::to_owned),
        help: description(schema),
        schema,
        kind: BranchKind::Exactly(value),
    }
}

/// Whether an object has all keys that a schema requires, and none that it does not know.
fn has_keys_of(object: &Map<String, Value>, schema: &Value) -> bool {
    let required = schema.get("required").and_then(Value::as_array);
    let mut required = required.into_iter().flatten().filter_map(Value::as_str);
    let known = schema.get("properties").and_then(Value::as_object);
    required.all(|key| object.contains_key(key))
        && known.is_none_or(|known| object.keys().all(|key| known.contains_key(key)))
}

/// Returns the type of a schema, and whether it may also be null.
fn type_of(schema: &Value) -> (&str, bool) {
    match schema.get("type") {
        Some(Value::String(name)) => (name, false),
        Some(Value::Array(names)) => {
            let mut some = names
                .iter()
                .filter_map(Value::as_str)
                .filter(|name| *name != "null");
            (
                some.next().unwrap_or("null"),
                names.iter().any(|name| name == "null"),
            )
        }
        _ => ("", false),
    }
}

/// Returns the name of a branch that has none in the file: its title, that of its variant, or its type.
fn plain_name(schema: &Value) -> String {
    if let Some(title) = schema.get("title").and_then(Value::as_str) {
        return title.to_owned();
    }
    let variant = rust_path(schema).map(|path| path.trim_end_matches("(_)"));
    let variant = variant.and_then(|path| path.rsplit("::").next());
    variant.map_or_else(|| type_of(schema).0.to_owned(), snake_case)
}

/// Returns the Rust path that the schema names for its variant.
pub fn rust_path(schema: &Value) -> Option<&str> {
    schema.get("x-rust")?.as_str()
}

fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for (index, letter) in name.char_indices() {
        if letter.is_uppercase() && index > 0 {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake
}

fn description(schema: &Value) -> &str {
    schema.get("description").and_then(Value::as_str).unwrap_or("")
}

/// Returns the help of a schema as plain text, its paragraphs as lines.
pub fn help(schema: &Value) -> String {
    plain(description(schema))
}

/// Takes links and line breaks out of a doc comment.
pub fn plain(text: &str) -> String {
    let text = text.replace("[`", "").replace("`]", "").replace('`', "");
    let paragraphs = text.split("\n\n").map(|lines| lines.replace('\n', " "));
    paragraphs.collect::<Vec<_>>().join("\n")
}

/// Returns a key in words.
pub fn label(key: &str) -> String {
    let words = key.replace("_deg", " (°)").replace('_', " ");
    let mut letters = words.chars();
    letters
        .next()
        .map(|first| first.to_uppercase().chain(letters).collect())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All schemas below one, with where they are.
    fn below<'a>(schema: &'a Value, at: String, to: &mut Vec<(String, &'a Value)>) {
        match schema {
            Value::Object(all) => {
                to.push((at.clone(), schema));
                all.iter()
                    .for_each(|(key, inner)| below(inner, format!("{at}/{key}"), to));
            }
            Value::Array(all) => {
                let inner = all.iter().enumerate();
                inner.for_each(|(index, inner)| below(inner, format!("{at}/{index}"), to));
            }
            _ => {}
        }
    }

    #[test]
    fn every_choice_knows_its_values_and_has_names_that_differ() {
        let schemas = Schemas::of(&Techniques::default());
        let mut all = Vec::new();
        below(&schemas.light, "light".to_owned(), &mut all);
        for (name, schema) in &schemas.defs {
            below(schema, name.clone(), &mut all);
        }
        for (name, schema) in &schemas.techniques {
            below(schema.as_ref().unwrap(), (*name).to_owned(), &mut all);
        }
        let mut count = 0;
        for (at, schema) in all {
            let Form::Choice(branches) = schemas.form(schema) else {
                continue;
            };
            if at == "light" || at.contains("/allOf/") {
                continue; // the kind of a light, and what it requires, are no choices of its settings
            }
            count += 1;
            assert!(!branches.is_empty(), "{at}");
            for (index, branch) in branches.iter().enumerate() {
                let first = schemas.first_of(branch);
                assert_eq!(schemas.branch_of(&branches, &first), Some(index), "{at}: {first}");
                assert!(
                    !["object", "boolean", "integer", "number"].contains(&&*branch.name),
                    "{at}: {}",
                    branch.name
                );
            }
        }
        assert!(count > 20, "{count}");
    }

    #[test]
    fn a_setting_begins_with_a_useful_value() {
        let schemas = Schemas::of(&Techniques::default());
        let of = |technique: &str, key: &str, branch: usize| {
            let property = &schemas.technique(technique).unwrap()["properties"][key];
            match schemas.form_of_some(property) {
                Form::Choice(branches) => schemas.first_of(&branches[branch]),
                _ => schemas.first(property),
            }
        };
        assert_eq!(of("shadow_map", "resolution", 0), json!(1024));
        assert_eq!(
            of("shadow_map", "resolution", 1),
            json!({"least": 128, "most": 1024})
        );
        assert_eq!(of("shadow_map", "near", 0), json!(0.05));
        assert_eq!(of("occlusion_texture", "resolution", 2), json!(64));
        let light = schemas.light("directional").unwrap();
        assert_eq!(light["properties"]["intensity"]["default"], json!(3.0));
        let Form::Choice(paths) = schemas.form_of_some(&light["properties"]["path"]) else {
            panic!("a path is a choice");
        };
        let names: Vec<&str> = paths.iter().map(|path| path.name.as_str()).collect();
        assert_eq!(names, ["arc", "sun", "positions"]);
    }
}
