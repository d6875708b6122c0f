//! The door for TOML: what its errors say.

use std::path::Path;

use lostmotion::toml_input::{Document, Range};

const FILE: &str = "model.toml";

fn parse(text: &str) -> Document {
    Document::parse(Path::new(FILE), text).expect("valid TOML")
}

/// The message of an error must be this, to the letter.
#[track_caller]
fn refused<T: std::fmt::Debug>(result: lostmotion::error::Result<T>, message: &str) {
    assert_eq!(result.expect_err("must be refused").to_string(), message);
}

#[test]
fn property_toml_errors_name_file_line_key_value_and_expectation() {
    let document = parse("a = -1\n\n[b.c]\nname = 3\nlist = [1, 2.5]\nsize = inf\n\n[[d]]\n[[d]]\nx = 'y'\n");
    let root = document.root();
    refused(root.number("a", &Range::positive("kg")), "model.toml:1: a = -1: expected a number > 0 [kg]");
    refused(root.number("z", &Range::any("kg")), "model.toml:1: z: expected a finite number [kg] (missing)");
    let c = root.table("b").unwrap().table("c").unwrap();
    refused(c.text("name"), "model.toml:4: b.c.name = 3: expected text in quotes");
    refused(c.text("nome"), "model.toml:3: b.c.nome: expected text in quotes (missing)");
    refused(
        c.optional_vector::<3>("list", &Range::any("m")),
        "model.toml:5: b.c.list = [1, 2.5]: expected a list of 3, each a finite number [m]",
    );
    refused(c.number("size", &Range::any("m")), "model.toml:6: b.c.size = inf: expected a finite number [m]");
    refused(
        c.optional_choice("name", &[("signed", 1), ("absolute", 2)]),
        "model.toml:4: b.c.name = 3: expected \"signed\" or \"absolute\"",
    );
    let d = root.tables("d").unwrap();
    refused(d[1].remaining_numbers(), "model.toml:10: d[2].x = 'y': expected a finite number [SI]");
}

#[test]
fn property_toml_unknown_keys_are_refused_with_the_nearest_known_one() {
    let document = parse("gear_ratoi = 1\n");
    let root = document.root();
    root.optional_number("gear_ratio", &Range::any("1")).unwrap();
    root.optional_text("name").unwrap();
    refused(root.finish(), "model.toml:1: gear_ratoi = 1: expected the key `gear_ratio` (unknown key)");
    let document = parse("\ncolour = 1\n");
    let root = document.root();
    root.optional_text("name").unwrap();
    refused(root.finish(), "model.toml:2: colour = 1: expected one of the keys `name` (unknown key)");
}

#[test]
fn property_toml_broken_syntax_names_its_line() {
    let error = Document::parse(Path::new(FILE), "a = 1\nb = = 2\n").unwrap_err().to_string();
    assert!(error.starts_with("model.toml:2: expected TOML: "), "{error}");
}

#[test]
fn property_toml_values_set_by_assignment_replace_those_of_the_file() {
    let mut document = parse("[control]\nkp = 1\n");
    document.set("control.kp = 2.5").unwrap();
    document.set("name=arm two").unwrap();
    let root = document.root();
    assert_eq!(root.table("control").unwrap().number("kp", &Range::any("1")).unwrap(), 2.5);
    assert_eq!(root.text("name").unwrap(), "arm two");
    document.set("control.kp = -3").unwrap();
    let root = document.root();
    refused(
        root.table("control").unwrap().number("kp", &Range::positive("1")),
        "model.toml: control.kp = -3: expected a number > 0 [1]",
    );
    refused(parse("").set("kp"), "model.toml: kp: expected an assignment KEY=VALUE");
}
