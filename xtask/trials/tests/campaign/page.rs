//! The campaign's report page.

use super::desk::report;
use std::path::Path;

/// The texts between two marks.
fn between<'a>(text: &'a str, from: &'a str, to: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(from).skip(1).filter_map(move |rest| rest.split_once(to).map(|(found, _)| found))
}

#[test]
fn the_page_counts_what_the_json_counts() {
    let report = report(0..64);
    let counted = serde_json::to_value(&report).unwrap();
    let page = report.page(&[Path::new("scene.toml").to_owned()]).html();
    let rows = counted["rows"].as_array().unwrap();
    assert!(rows.len() > 3, "{}", rows.len());
    let (_, table) = page.split_once("Faults in states, and how runs ended").unwrap();
    let (table, _) = table.split_once("</table>").unwrap();
    let shown: Vec<Vec<&str>> = between(table, "<tr>", "</tr>")
        .map(|row| between(row, "<td", "</td>").map(|cell| cell.rsplit_once('>').unwrap().1).collect::<Vec<_>>())
        .filter(|row| !row.is_empty())
        .collect();
    assert_eq!(shown.len(), rows.len());
    for (shown, row) in shown.iter().zip(rows) {
        let numbers = ["runs", "ticks", "unsafe_commands"].map(|key| row[key].to_string());
        assert_eq!(shown.last_chunk::<3>().unwrap(), &numbers.each_ref().map(|number| number.as_str()), "{row}");
    }
    // Every run is in one bar of the figure.
    let runs =
        between(&page, "<title>", "</title>").filter_map(|title| title.rsplit_once(": ")?.1.strip_suffix(" runs"));
    assert_eq!(runs.map(|runs| runs.parse::<u64>().unwrap()).sum::<u64>(), 64);
}
