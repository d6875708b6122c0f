//! `docs/recording.png` is no text; the result that it shows stands beside it in `docs/recording.txt`, with a checksum of the picture, both
//! written by `docs/refresh` when it makes the picture.

use std::fs;
use std::path::Path;

use libtest_mimic::Failed;

use super::examples;
use super::figures::{self, Table};

/// 64 bits of the file's content (FNV-1a): enough to see that another picture lies there.
fn checksum(bytes: &[u8]) -> String {
    let fold = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, fold))
}

/// What the picture shows of the README's demonstration: the lines of its verdict.
fn verdict(readme: &str) -> Vec<String> {
    let demo = examples::of(readme).into_iter().find(|example| example.command == "lostmotion demo");
    let printed = demo.map_or_else(Vec::new, |demo| demo.printed);
    printed.into_iter().skip(2).take_while(|line| !line.is_empty()).collect()
}

/// The picture shows what the README says.
pub fn check(root: &Path) -> Result<(), Failed> {
    let readme = fs::read_to_string(root.join("README.md"))?;
    let noted = fs::read_to_string(root.join("docs/recording.txt"))?;
    let (sum, shown) = noted.split_once('\n').unwrap_or_default();
    let picture = fs::read(root.join("docs/recording.png"))?;
    if sum != checksum(&picture) {
        return Err(
            "docs/recording.png is not the picture that docs/recording.txt tells of: make both by docs/refresh".into(),
        );
    }
    let (verdict, shown): (Vec<String>, Vec<&str>) = (verdict(&readme), shown.lines().collect());
    let same = verdict.len() == shown.len()
        && verdict.iter().zip(&shown).all(|(line, shown)| figures::agree(line, shown, &Table::default()));
    if verdict.is_empty() || !same {
        return Err(format!(
            "docs/recording.png is out of date: make it by docs/refresh\nREADME:  {verdict:#?}\npicture: {shown:#?}"
        )
        .into());
    }
    Ok(())
}

/// Writes what the picture that lies there now shows: for whoever has just made it.
pub fn note(root: &Path) -> Result<(), Failed> {
    let readme = fs::read_to_string(root.join("README.md"))?;
    let picture = fs::read(root.join("docs/recording.png"))?;
    let text = format!("{}\n{}\n", checksum(&picture), verdict(&readme).join("\n"));
    fs::write(root.join("docs/recording.txt"), text)?;
    Ok(())
}

/// Checks of the above.
pub mod checks {
    use super::*;

    pub fn a_picture_of_other_figures_or_another_picture_is_seen() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        let readme = |tilt: &str| {
            format!("```console\n$ lostmotion demo\ntitle\n\nbase_tilt (tilt = {tilt} ± 0.0034°)\n\nmore\n```\n")
        };
        let write = |name: &str, text: &str| fs::write(root.join(name), text).expect("written");
        fs::create_dir(root.join("docs")).expect("a folder");
        write("README.md", &readme("0.5721"));
        write("docs/recording.png", "a picture");
        note(root).expect("noted");
        assert!(check(root).is_ok());
        write("README.md", &readme("0.5760"));
        assert!(check(root).is_err(), "the figures have moved by more than a standard error");
        write("README.md", &readme("0.5722"));
        assert!(check(root).is_ok(), "other last digits are no other figures");
        write("docs/recording.png", "another picture");
        assert!(check(root).is_err());
    }
}
