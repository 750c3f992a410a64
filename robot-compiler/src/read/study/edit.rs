//! Edits of a TOML document at a path of keys, such as `joint.elbow.friction.coulomb`.

use crate::describe::diagnostics::{nearest, one_of};
use toml_edit::{DocumentMut, InlineTable, Item, TableLike};

/// Problem of a path, and what was expected.
pub(super) type Problem = (String, String);

/// Edit of a value to which a path leads. A missing key is passed as [`Item::None`].
type Edit<'a> = &'a mut dyn FnMut(&mut Item) -> Result<(), Problem>;

/// Edits every value to which the path leads. Missing tables are created.
///
/// A name in a list is a joint's name, its number counted from 1, or `*` for all; `joints` are the names.
pub(super) fn edit(
    document: &mut DocumentMut,
    path: &[&str],
    joints: &[String],
    edit: Edit<'_>,
) -> Result<(), Problem> {
    in_table(document.as_table_mut(), path, joints, edit)
}

fn in_table(table: &mut dyn TableLike, path: &[&str], joints: &[String], edit: Edit<'_>) -> Result<(), Problem> {
    let [key, rest @ ..] = path else {
        return Err(("leads to a table".to_owned(), "a path that ends at a value".to_owned()));
    };
    if table.get(key).is_none_or(Item::is_none) {
        let mut made = if rest.is_empty() { Item::None } else { toml_edit::value(InlineTable::new()) };
        at(&mut made, key, rest, joints, edit).map_err(|(problem, expected)| {
            let known: Vec<&str> = table.iter().map(|(known, _)| known).collect();
            let guess = nearest(key, &known).map_or(String::new(), |guess| format!("; did you mean `{guess}`?"));
            (problem, expected + &guess)
        })?;
        table.insert(key, made);
        return Ok(());
    }
    table.get_mut(key).map_or(Ok(()), |item| at(item, key, rest, joints, edit))?;
    if table.get(key).is_some_and(Item::is_none) {
        table.remove(key);
    }
    Ok(())
}

fn at(item: &mut Item, name: &str, path: &[&str], joints: &[String], edit: Edit<'_>) -> Result<(), Problem> {
    let [which, rest @ ..] = path else { return edit(item) };
    if let Some(tables) = item.as_array_of_tables_mut() {
        let names: Vec<String> = tables.iter().map(|table| name_of(table)).collect();
        for index in chosen(which, name, &names)? {
            tables.get_mut(index).map_or(Ok(()), |table| in_table(table, rest, joints, edit))?;
        }
        return Ok(());
    }
    if let Some(array) = item.as_array_mut() {
        let own: Vec<String> = array
            .iter()
            .map(|value| value.as_inline_table().map_or_else(String::new, |table| name_of(table)))
            .collect();
        let named = own.iter().any(|name| !name.is_empty());
        let count = own.len();
        let names = if named || count != joints.len() { &own } else { joints };
        for index in chosen(which, name, names)? {
            let Some(value) = array.get_mut(index) else { continue };
            let mut element = Item::Value(value.clone());
            at(&mut element, which, rest, joints, edit)?;
            if let Ok(changed) = element.into_value() {
                *value = changed;
            }
        }
        return Ok(());
    }
    match item.as_table_like_mut() {
        Some(table) => in_table(table, path, joints, edit),
        None => Err((format!("`{name}` is a value, which has no key `{which}`"), "the path of a value".to_owned())),
    }
}

fn name_of(table: &dyn TableLike) -> String {
    table.get("name").and_then(Item::as_str).unwrap_or_default().to_owned()
}

/// Indices of a list that a name chooses.
fn chosen(which: &str, list: &str, names: &[String]) -> Result<Vec<usize>, Problem> {
    if which == "*" {
        return Ok((0..names.len()).collect());
    }
    if let Some(index) = names.iter().position(|name| name == which) {
        return Ok(vec![index]);
    }
    if let Some(index) = which.parse::<usize>().ok().and_then(|number| number.checked_sub(1))
        && index < names.len()
    {
        return Ok(vec![index]);
    }
    let known: Vec<&str> = names.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
    let expected = format!("a number from 1 to {}, `*` for all, or {}", names.len(), one_of(which, &known));
    Err((format!("`{list}` has no `{which}`"), expected))
}
