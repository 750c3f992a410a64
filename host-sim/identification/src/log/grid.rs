//! A text file as a header, a row of units and rows of fields.

use super::fields::{Separator, between_blanks, comment, elements, is_list, is_missing, number, numbers};
use super::unit::Unit;
use csv::StringRecord;

/// Found and expected content.
pub(super) type Problem = (String, String);

/// A table of text.
#[derive(Debug)]
pub(super) struct Grid {
    /// Names of the columns.
    pub(super) head: Vec<String>,
    /// Line of the header, counted from 1.
    pub(super) head_line: u64,
    /// The row of units under the header; empty if there is none.
    pub(super) units: Vec<String>,
    /// Line and fields of each row.
    pub(super) rows: Vec<(u64, StringRecord)>,
    /// Remarks for the report.
    pub(super) notes: Vec<String>,
}

/// True for a row of readings: at least two numbers, and at least half of the fields that are not empty.
fn is_data(fields: &[String]) -> bool {
    let (numbers, filled) = (numbers(fields), fields.iter().filter(|field| !is_missing(field)).count());
    numbers >= 2 && 2 * numbers >= filled
}

/// True for a row of units: every field is a unit, a hyphen, or empty.
fn is_units(fields: &[String]) -> bool {
    let is_unit = |field: &String| Unit::parse(field.trim_matches(['[', ']', '{', '}'])).is_some();
    let empty = |field: &String| matches!(field.as_str(), "" | "-" | "[-]" | "[]" | "()" | "(-)");
    fields.iter().any(is_unit) && fields.iter().all(|field| empty(field) || is_unit(field))
}

impl Grid {
    /// Reads a text with `\
    /// ` line endings.
    ///
    /// # Errors
    /// Place, what was found and what was expected: no rows of numbers, no header, a header of another length.
    pub(super) fn read(text: &str) -> Result<Self, (String, Problem)> {
        let lines: Vec<&str> = text.split('\n').collect();
        let readable = |line: &&str| !line.trim().is_empty() && comment(line).is_none();
        let some: Vec<&str> = lines.iter().copied().filter(readable).collect();
        let step = (some.len() / 40).max(1);
        // The right separator gives the most numbers in a typical row.
        let usual = |separator: Separator, of: fn(&[String]) -> usize| {
            let mut counts: Vec<usize> = some.iter().step_by(step).map(|line| of(&separator.fields(line))).collect();
            counts.sort_unstable();
            counts.get(counts.len() / 2).copied().unwrap_or(0)
        };
        let best = Separator::ALL.into_iter().rev().max_by_key(|separator| usual(*separator, numbers));
        let separator = best.unwrap_or(Separator::COMMA);
        let width = usual(separator, <[String]>::len);
        let first = lines.iter().position(|line| {
            readable(line) && {
                let fields = separator.fields(line);
                fields.len() == width && is_data(&fields)
            }
        });
        let Some(first) = first.filter(|_| width >= 2) else {
            let expected =
                "a header of column names, and rows of numbers below it (CSV; commas, semicolons, tabs or blanks)";
            return Err(("the whole file".to_owned(), ("no rows of numbers".to_owned(), expected.to_owned())));
        };
        // Earlier rows, in which few values had been measured yet.
        let begun = |fields: &[String]| {
            fields.len() == width
                && numbers(fields) > 0
                && fields.iter().all(|field| is_missing(field) || number(field).is_some())
        };
        let above = (0..first).rev().filter(|k| readable(&lines[*k]));
        let first = above.take_while(|k| begun(&separator.fields(lines[*k]))).last().unwrap_or(first);
        let mut grid = Self::under(&lines, first, separator, width)?;
        let whole: String = lines[first..]
            .iter()
            .map(|line| match separator {
                _ if !readable(line) => "\n".to_owned(),
                Separator::BLANKS => between_blanks(line, false).join("\t") + "\n",
                _ => format!("{line}\n"),
            })
            .collect();
        grid.rows = separator.rows(&whole).map(|(line, row)| (line + first as u64, row)).collect();
        let cut = grid.rows.last().is_some_and(|(_, row)| row.len() < width) && !text.ends_with('\n');
        if let (true, Some((line, _))) = (cut, grid.rows.last()) {
            grid.notes.push(format!("line {line} is left out: the file ends within it"));
            grid.rows.pop();
        }
        grid.expand();
        Ok(grid)
    }

    /// Reads the header and the units above the first row of numbers.
    fn under(lines: &[&str], first: usize, separator: Separator, width: usize) -> Result<Self, (String, Problem)> {
        let mut grid = Self { head: Vec::new(), head_line: 0, units: Vec::new(), rows: Vec::new(), notes: Vec::new() };
        let split = |line: &str, by: Separator| {
            let fields = by.fields(line);
            if by == Separator::BLANKS && fields.len() != width { between_blanks(line, true) } else { fields }
        };
        let plain = (0..first).rev().filter(|k| !lines[*k].trim().is_empty() && comment(lines[*k]).is_none());
        let plain: Vec<usize> = plain.filter(|k| !lines[*k].to_lowercase().starts_with("sep=")).collect();
        for &k in &plain {
            let fields = split(lines[k], separator);
            // Units may be separated by blanks even if the rows use another separator.
            let apart = separator.fields(lines[k]);
            if grid.units.is_empty() && is_units(&apart) && plain.len() > 1 {
                grid.units = apart;
                continue;
            }
            grid.head = fields;
            grid.head_line = k as u64 + 1;
            break;
        }
        // Some programs write the header as a comment.
        if grid.head.is_empty() {
            for k in (0..first).rev() {
                let Some(text) = comment(lines[k]) else { continue };
                let ways = [separator, Separator::COMMA, Separator::TAB, Separator::SEMICOLON, Separator::BLANKS];
                let Some(fields) = ways.into_iter().map(|by| split(text, by)).find(|fields| fields.len() == width)
                else {
                    continue;
                };
                if grid.units.is_empty() && is_units(&fields) {
                    grid.units = fields;
                } else if numbers(&fields) == 0 {
                    grid.head = fields;
                    grid.head_line = k as u64 + 1;
                    break;
                }
            }
        }
        // Units may be above the header, or in a comment.
        let units = (0..first).filter(|k| grid.units.is_empty() && *k as u64 + 1 != grid.head_line).find_map(|k| {
            let fields = split(comment(lines[k]).unwrap_or(lines[k]), separator);
            (fields.len() == width && is_units(&fields)).then_some(fields)
        });
        grid.units = units.unwrap_or(grid.units);
        let place = |line: u64| format!("line {line}");
        if grid.head.is_empty() {
            // Columns can still be named by their numbers.
            grid.head = (1..=width).map(|k| format!("#{k}")).collect();
            return Ok(grid);
        }
        let left_out = |k: &&usize| (**k as u64) + 1 < grid.head_line && !is_units(&separator.fields(lines[**k]));
        if let Some(&above) = plain.iter().find(left_out) {
            grid.notes.push(format!("line {} and those before it are left out: they are above the header", above + 1));
        }
        let filled = grid.head.iter().rposition(|name| !name.is_empty()).map_or(0, |last| last + 1);
        let row = separator.fields(lines[first]);
        let beyond = row.iter().skip(grid.head.len()).filter(|field| !field.is_empty()).count();
        if beyond > 0 {
            let found = format!("{} fields between {}, and {filled} names in the header", row.len(), separator.name);
            let decimal = separator == Separator::COMMA && row.len() * 2 >= filled * 3;
            let cause = if decimal {
                "as many as names. Decimal commas between commas cannot be told apart: export with decimal points, or with semicolons"
            } else {
                "as many fields as names"
            };
            return Err((place(first as u64 + 1), (found, cause.to_owned())));
        }
        Ok(grid)
    }

    /// Replaces a column of lists (`[0.1, 0.2]`) by a column for each element.
    fn expand(&mut self) {
        let first = |k: usize| self.rows.iter().find_map(|(_, row)| row.get(k).filter(|field| !field.is_empty()));
        let lists: Vec<Option<usize>> = (0..self.head.len())
            .map(|k| first(k).filter(|field| is_list(field)).map(|field| elements(field).len()))
            .collect();
        if lists.iter().all(Option::is_none) {
            return;
        }
        let spread = |fields: Vec<String>, of: &dyn Fn(&str, usize) -> Vec<String>| -> Vec<String> {
            let each = fields.into_iter().enumerate();
            each.flat_map(|(k, field)| match lists.get(k).copied().flatten() {
                Some(count) => of(&field, count),
                None => vec![field],
            })
            .collect()
        };
        let numbered = |name: &str, count: usize| (0..count).map(|k| format!("{name}[{k}]")).collect();
        let repeated = |unit: &str, count: usize| vec![unit.to_owned(); count];
        let parts = |field: &str, count: usize| {
            let mut parts = elements(field);
            parts.resize(count, String::new());
            parts
        };
        self.head = spread(std::mem::take(&mut self.head), &numbered);
        self.units = spread(std::mem::take(&mut self.units), &repeated);
        for (_, row) in &mut self.rows {
            *row = spread(row.iter().map(str::to_owned).collect(), &parts).into_iter().collect();
        }
    }
}
