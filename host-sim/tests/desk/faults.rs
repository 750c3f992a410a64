//! The only list of faults: its numbers, and the table in the documentation.

use dynamics_core::Fault;
use std::fmt::Write as _;
use std::path::Path;

#[test]
fn numbers_are_stable_and_lead_back_to_their_faults() {
    for (index, fault) in Fault::ALL.iter().enumerate() {
        assert_eq!(usize::from(fault.code()), index + 1);
        assert_eq!(Fault::from_code(fault.code(), 0), Some(*fault));
        let third = Fault::from_code(fault.code(), 2).unwrap();
        assert_eq!(third.joint(), fault.joint().map(|_| 2));
        let said = third.to_string();
        assert!(said.starts_with(&format!("fault {}: {}", fault.code(), fault.text())), "{said}");
        assert_eq!(said.ends_with(" (joint 3)"), fault.joint().is_some(), "{said}");
        assert!(!fault.raised().is_empty() && !fault.check().ends_with('.'), "{said}");
    }
    let count = Fault::ALL.len() as u8;
    assert_eq!((Fault::from_code(0, 0), Fault::from_code(count + 1, 0)), (None, None));
    // Old records are read by these numbers, so they must not change.
    assert_eq!(Fault::ALL[8], Fault::EmergencyStop);
    assert_eq!(Fault::ALL[14], Fault::FollowingError { joint: 0 });
}

/// `UPDATE_EMITTED=1` rewrites the table.
#[test]
fn the_table_of_the_documentation_is_the_list() {
    const BEGIN: &str = "<!-- generated: faults -->\n";
    const END: &str = "<!-- end generated: faults -->";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/operate/faults.md");
    let mut table = "\n| code | fault | raised when | check |\n|---|---|---|---|\n".to_owned();
    for fault in Fault::ALL {
        let _ = writeln!(table, "| {} | {} | {} | {} |", fault.code(), fault.text(), fault.raised(), fault.check());
    }
    table.push('\n');
    let page = std::fs::read_to_string(&path).unwrap();
    let (head, rest) = page.split_once(BEGIN).unwrap();
    let (found, tail) = rest.split_once(END).unwrap();
    if std::env::var_os("UPDATE_EMITTED").is_some() {
        std::fs::write(&path, format!("{head}{BEGIN}{table}{END}{tail}")).unwrap();
        return;
    }
    assert_eq!(found, table, "docs/operate/faults.md: UPDATE_EMITTED=1 cargo nextest run -p host-sim writes it");
}

/// The entries below the table are written by hand; their headings match the list.
#[test]
fn every_fault_has_an_entry_under_its_number_and_text() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/operate/faults.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let mut entries = page.split("\n## Fault ").skip(1);
    for fault in Fault::ALL {
        let entry = entries.next().unwrap_or_else(|| panic!("docs/operate/faults.md has no entry for {fault}"));
        let (heading, body) = entry.split_once('\n').unwrap();
        assert_eq!(heading, format!("{}: {}", fault.code(), fault.text()), "docs/operate/faults.md");
        for part in ["**Likely causes**", "**Check**", "**To clear it**"] {
            assert!(body.contains(part), "docs/operate/faults.md: fault {}: {part}", fault.code());
        }
    }
    assert_eq!(entries.next(), None, "docs/operate/faults.md has an entry too many");
}
