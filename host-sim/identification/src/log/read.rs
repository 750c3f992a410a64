//! Reading of a log from the bytes of a file.

use super::{BadLog, Log, Reading, check, clock, decode, fields, foreign, grid, header};

impl Log {
    /// Reads and checks a text file with a header. Also returns remarks on its interpretation.
    ///
    /// Columns: `time` (or `t`, in s; or `tick`), and per joint `q_1` .., optionally `qd_1` .., and `tau_1` .. or `current_1` ... The manual of
    /// `newtau identify` lists other names, units and separators that are understood. A row in which all positions, or all torques, are empty is left
    /// out. Other columns are ignored.
    ///
    /// # Errors
    /// [`BadLog`] names the line and the column of: a column that is missing or duplicated, two columns that fit equally well, an unknown unit, a
    /// field that is no number, time that runs backwards or has a gap, impossible units, a joint that never moves, clipped torques, columns of two
    /// joints exchanged, too few samples.
    pub fn read_noted(bytes: &[u8], file: &str, reading: &Reading) -> Result<(Self, Vec<String>), BadLog> {
        let wrong = |place: String, (found, expected): (String, String)| BadLog {
            file: file.to_owned(),
            place,
            found,
            expected,
        };
        let whole = |problem| wrong("the whole file".to_owned(), problem);
        if let Some(problem) = foreign::problem(bytes) {
            return Err(whole(problem));
        }
        let text = decode::text(bytes)
            .map_err(|found| whole((found, "a text file: UTF-8, UTF-16 or Windows-1252".to_owned())))?;
        let mut grid = grid::Grid::read(&text).map_err(|(place, problem)| wrong(place, problem))?;
        let head_line = format!("line {}", grid.head_line.max(1));
        let places = header::Places::find(&grid, reading).map_err(|problem| wrong(head_line, problem))?;
        let mut notes = std::mem::take(&mut grid.notes);
        notes.extend(places.notes.iter().cloned());
        let rows: Vec<&(u64, csv::StringRecord)> = grid
            .rows
            .iter()
            .filter(|(_, row)| {
                // A record contains ticks without a reading or a torque before the arm is armed.
                let empty = |of: &[usize]| of.iter().all(|place| row.get(*place).is_some_and(fields::is_missing));
                !empty(places.positions()) && !empty(places.torques())
            })
            .collect();
        if rows.is_empty() && !grid.rows.is_empty() {
            let found = format!("positions and torques in the same row in none of {} rows", grid.rows.len());
            return Err(whole((found, "positions and torques of the same time in each row: resample them".to_owned())));
        }
        let lines: Vec<u64> = rows.iter().map(|(line, _)| *line).collect();
        let nanos = if let clock::Clock::Stamp(place) = places.clock { place } else { places.all[0] };
        let stamps: Vec<(&str, &str)> =
            rows.iter().map(|(_, row)| (row.get(places.all[0]).unwrap_or(""), row.get(nanos).unwrap_or(""))).collect();
        let (time, judged) = places
            .clock
            .seconds(&stamps)
            .map_err(|(k, problem)| wrong(format!("line {}, {}", lines[k], grid.head[places.all[0]]), problem))?;
        notes.extend(judged);
        let mut columns = vec![time];
        let (mut point, mut comma) = (None, None);
        for (&place, factor) in places.all.iter().zip(&places.factors).skip(1) {
            let mut column = Vec::with_capacity(rows.len());
            for (line, row) in &rows {
                let text = row.get(place).unwrap_or("");
                if fields::is_missing(text) && places.speeds().contains(&place) {
                    column.push(f64::NAN);
                    continue;
                }
                let place = || format!("line {line}, {}", grid.head[place]);
                let number = fields::number(text).ok_or_else(|| {
                    let found = if text.is_empty() { "nothing".to_owned() } else { format!("{text:?}") };
                    let expected = match text.contains(',') && text.contains('.') {
                        true => "a number without separators of thousands",
                        false => "a finite number",
                    };
                    wrong(place(), (found, expected.to_owned()))
                })?;
                if text.contains(',') {
                    comma.get_or_insert((*line, text));
                } else if text.contains('.') {
                    point.get_or_insert((*line, text));
                }
                if let (Some((_, a)), Some((_, b))) = (point, comma) {
                    let found = format!("{text:?}: both decimal points ({a}) and decimal commas ({b})");
                    return Err(wrong(place(), (found, "one of both in the whole file".to_owned())));
                }
                column.push(number * factor);
            }
            columns.push(column);
        }
        let table = check::Table { file, head: &grid.head, places: &places, lines: &lines };
        Ok((table.checked(columns, reading)?, notes))
    }

    /// Same as [`Log::read_noted`], without remarks.
    ///
    /// # Errors
    /// As [`Log::read_noted`].
    pub fn read(bytes: &[u8], file: &str, reading: &Reading) -> Result<Self, BadLog> {
        Self::read_noted(bytes, file, reading).map(|(log, _)| log)
    }
}
