//! A widget for each setting, made from its schema.

use egui::{ComboBox, DragValue, Response, RichText, Slider, Ui};
use serde_json::{Map, Value, json};

use crate::schema::{Bounds, Branch, BranchKind, Form, Schemas, help, label, plain};

/// Width of the names beside the widgets, points.
const NAMES: f32 = 104.0;

/// Shows the properties of an object, except those of `hidden`, and edits them. Returns the key that changed.
///
/// Keys that are missing have their default. A key that is set back to its default is removed.
pub fn object(
    ui: &mut Ui,
    schemas: &Schemas,
    schema: &Value,
    values: &mut Map<String, Value>,
    hidden: &[&str],
) -> Option<String> {
    let Form::Object(properties) = schemas.form_of_some(schema) else {
        return None;
    };
    let required = schemas.resolve(schema).get("required").and_then(Value::as_array);
    let is_required = |key: &str| required.is_some_and(|keys| keys.iter().any(|known| known == key));
    let mut changed = None;
    for (key, property) in properties {
        if hidden.contains(&key.as_str()) {
            continue;
        }
        let default = property.get("default").cloned().unwrap_or(Value::Null);
        let is_set = values.get(key).is_some_and(|value| !value.is_null());
        let mut value = values
            .get(key)
            .filter(|value| !value.is_null())
            .unwrap_or(&default)
            .clone();
        let before = value.clone();
        ui.push_id(key, |ui| {
            setting(
                ui,
                schemas,
                key,
                property,
                &mut value,
                is_set && !is_required(key),
            );
        });
        if value != before {
            if !is_required(key) && (value == default || value.is_null()) {
                values.remove(key);
            } else {
                values.insert(key.clone(), value);
            }
            changed = Some(key.clone());
        }
    }
    changed
}

/// Shows one setting with its name. A name whose setting is not the default is bright, and a click on it sets the
/// default.
fn setting(ui: &mut Ui, schemas: &Schemas, key: &str, property: &Value, value: &mut Value, is_set: bool) {
    let mut text = help(property);
    if text.is_empty() {
        text = help(schemas.resolve(property));
    }
    let is_nested = is_nested(schemas, property, value);
    ui.horizontal(|ui| {
        let name = RichText::new(label(key));
        let name = if is_set { name.strong() } else { name };
        let mut shown = self::name(ui, name);
        if is_set {
            text += "\nClick to set the default.";
        }
        if !text.is_empty() {
            shown = shown.on_hover_text(text);
        }
        if is_set && shown.clicked() {
            *value = property.get("default").cloned().unwrap_or(Value::Null);
        } else {
            head(ui, schemas, property, value);
        }
    });
    if is_nested {
        ui.indent("nested", |ui| body(ui, schemas, property, value));
    }
}

/// Shows the name of a setting, in a column of names.
pub fn name(ui: &mut Ui, name: RichText) -> Response {
    let space = egui::vec2(NAMES, ui.spacing().interact_size.y);
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    let shown = ui.allocate_ui_with_layout(space, layout, |ui| {
        ui.set_min_width(NAMES);
        ui.add(egui::Label::new(name).sense(egui::Sense::click()).truncate())
    });
    shown.inner
}

/// Whether a value has settings of its own below it.
fn is_nested(schemas: &Schemas, schema: &Value, value: &Value) -> bool {
    match schemas.form(schema) {
        Form::Object(_) => true,
        Form::Optional(inner) if !value.is_null() => match schemas.form_of_some(inner) {
            Form::Object(_) => true,
            Form::Choice(branches) => has_settings(schemas, &branches, value),
            _ => false,
        },
        Form::Choice(branches) => has_settings(schemas, &branches, value),
        _ => false,
    }
}

fn has_settings(schemas: &Schemas, branches: &[Branch], value: &Value) -> bool {
    let branch = schemas.branch_of(branches, value);
    let branch = branch.and_then(|index| branches.get(index));
    branch.is_some_and(|branch| !matches!(branch.kind, BranchKind::Exactly(_)))
}

/// The part of a widget beside its name.
fn head(ui: &mut Ui, schemas: &Schemas, schema: &Value, value: &mut Value) {
    match schemas.form(schema) {
        Form::Flag => {
            let mut flag = value.as_bool().unwrap_or(false);
            if ui.checkbox(&mut flag, "").changed() {
                *value = json!(flag);
            }
        }
        Form::Number(bounds) => optional_number(ui, schemas, schema, bounds, value),
        Form::Text => text(ui, value),
        Form::Texts => texts(ui, value),
        Form::Row(count, item) => row(ui, schemas, count, item, value),
        Form::Object(_) => {}
        Form::Choice(branches) => menu(ui, schemas, &branches, value),
        // A missing value is shown as its default.
        Form::Optional(inner) if schema.get("default").is_some_and(|default| !default.is_null()) => {
            some(ui, schemas, inner, value);
        }
        Form::Optional(inner) => {
            let mut is_there = !value.is_null();
            if ui.checkbox(&mut is_there, "").changed() {
                *value = if is_there {
                    schemas.first(inner)
                } else {
                    Value::Null
                };
            }
            if is_there {
                some(ui, schemas, inner, value);
            } else {
                ui.weak("default");
            }
        }
        Form::Other => json_text(ui, value),
    }
}

/// The part of a widget beside its name, for a value that is there.
fn some(ui: &mut Ui, schemas: &Schemas, schema: &Value, value: &mut Value) {
    match schemas.form_of_some(schema) {
        Form::Number(bounds) => number(ui, bounds, value),
        Form::Choice(branches) => menu(ui, schemas, &branches, value),
        Form::Row(count, item) => row(ui, schemas, count, item, value),
        Form::Text => text(ui, value),
        Form::Texts => texts(ui, value),
        Form::Flag | Form::Object(_) | Form::Optional(_) | Form::Other => {}
    }
}

/// The part of a widget below its name.
fn body(ui: &mut Ui, schemas: &Schemas, schema: &Value, value: &mut Value) {
    match schemas.form_of_some(schema) {
        Form::Object(_) => {
            let mut values = value.as_object().cloned().unwrap_or_default();
            if object(ui, schemas, schema, &mut values, &[]).is_some() {
                *value = Value::Object(values);
            }
        }
        Form::Choice(branches) => {
            let branch = schemas.branch_of(&branches, value);
            match branch.and_then(|index| branches.get(index)) {
                Some(Branch {
                    kind: BranchKind::Keyed(key, inner),
                    ..
                }) => {
                    if let Some(value) = value.get_mut(*key) {
                        match schemas.form_of_some(inner) {
                            Form::Object(_) => body(ui, schemas, inner, value),
                            _ => head(ui, schemas, inner, value),
                        }
                    }
                }
                Some(branch) => match schemas.form_of_some(branch.schema) {
                    Form::Object(_) => body(ui, schemas, branch.schema, value),
                    _ => head(ui, schemas, branch.schema, value),
                },
                None => {}
            }
        }
        _ => {}
    }
}

fn menu(ui: &mut Ui, schemas: &Schemas, branches: &[Branch], value: &mut Value) {
    let now = schemas.branch_of(branches, value);
    let name = now
        .and_then(|index| branches.get(index))
        .map(|branch| branch.name.clone());
    ComboBox::from_id_salt("choice")
        .selected_text(name.as_deref().map_or_else(|| "?".to_owned(), label))
        .width(ui.available_width().clamp(60.0, 150.0))
        .show_ui(ui, |ui| {
            for (index, branch) in branches.iter().enumerate() {
                if branches[..index].iter().any(|other| other.name == branch.name) {
                    continue; // the first way to write it is enough
                }
                let is_now = name.as_ref() == Some(&branch.name);
                let mut shown = ui.selectable_label(is_now, label(&branch.name));
                if !branch.help.is_empty() {
                    shown = shown.on_hover_text(plain(branch.help));
                }
                if shown.clicked() && !is_now {
                    *value = schemas.first_of(branch);
                }
            }
        });
}

/// A number whose default is no number in JSON, such as infinity, can be left out.
fn optional_number(ui: &mut Ui, schemas: &Schemas, schema: &Value, bounds: Bounds, value: &mut Value) {
    let is_optional = schema.get("default").is_some_and(Value::is_null);
    if is_optional {
        let mut is_there = !value.is_null();
        if ui.checkbox(&mut is_there, "").changed() {
            *value = if is_there {
                schemas.first(schema)
            } else {
                Value::Null
            };
        }
        if !is_there {
            ui.weak("no limit");
            return;
        }
    }
    number(ui, bounds, value);
}

fn number(ui: &mut Ui, bounds: Bounds, value: &mut Value) {
    let mut number = value.as_f64().unwrap_or(bounds.least.unwrap_or(0.0));
    let shown = show_number(ui, bounds, &mut number);
    if shown.changed() {
        *value = if bounds.whole {
            json!(number.round() as i64)
        } else {
            json!(significant(number))
        };
    }
}

fn show_number(ui: &mut Ui, bounds: Bounds, number: &mut f64) -> Response {
    if let (Some(least), Some(most)) = (bounds.least, bounds.most) {
        ui.spacing_mut().slider_width = (ui.available_width() - 60.0).clamp(40.0, 140.0);
        let slider = Slider::new(number, least..=most);
        return ui.add(if bounds.whole { slider.integer() } else { slider });
    }
    let range = bounds.least.unwrap_or(f64::MIN)..=bounds.most.unwrap_or(f64::MAX);
    let speed = if bounds.whole {
        1.0
    } else {
        (number.abs() * 0.01).max(0.001)
    };
    let decimals = usize::from(!bounds.whole) * 5;
    ui.add(
        DragValue::new(number)
            .range(range)
            .speed(speed)
            .max_decimals(decimals),
    )
}

/// Rounds to six digits, which an `f32` holds.
fn significant(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

fn row(ui: &mut Ui, schemas: &Schemas, count: usize, item: &Value, value: &mut Value) {
    let Form::Number(bounds) = schemas.form_of_some(item) else {
        json_text(ui, value);
        return;
    };
    let mut parts = value.as_array().cloned().unwrap_or_default();
    parts.resize(count, json!(0));
    ui.spacing_mut().item_spacing.x = 3.0;
    let before = parts.clone();
    for part in &mut parts {
        let mut number = part.as_f64().unwrap_or(0.0);
        let range = bounds.least.unwrap_or(f64::MIN)..=bounds.most.unwrap_or(f64::MAX);
        let drag = DragValue::new(&mut number)
            .range(range)
            .speed(if bounds.whole { 0.1 } else { 0.02 });
        let drag = drag.max_decimals(usize::from(!bounds.whole) * 3);
        if ui.add(drag).changed() {
            *part = if bounds.whole {
                json!(number.round() as i64)
            } else {
                json!(significant(number))
            };
        }
    }
    if parts != before {
        *value = Value::Array(parts);
    }
}

fn text(ui: &mut Ui, value: &mut Value) {
    let mut text = value.as_str().unwrap_or("").to_owned();
    if ui.text_edit_singleline(&mut text).changed() {
        *value = if text.is_empty() { Value::Null } else { json!(text) };
    }
}

fn texts(ui: &mut Ui, value: &mut Value) {
    let all = value.as_array().into_iter().flatten().filter_map(Value::as_str);
    let mut line = all.collect::<Vec<_>>().join(", ");
    if ui.text_edit_singleline(&mut line).changed() {
        let all: Vec<&str> = line.split(',').map(str::trim).collect();
        *value = if line.trim().is_empty() {
            Value::Null
        } else {
            json!(all)
        };
    }
}

/// Edits a value as JSON text, which is taken over when it is one.
fn json_text(ui: &mut Ui, value: &mut Value) {
    let mut text = value.to_string();
    if ui.text_edit_singleline(&mut text).changed()
        && let Ok(parsed) = serde_json::from_str(&text)
    {
        *value = parsed;
    }
}
