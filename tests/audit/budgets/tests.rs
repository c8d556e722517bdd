use super::*;

const FILE: &str = r#"
# Kept.
compiler = "rustc 1"
[figures]
"flash.a" = { figure = 100, limit = 120, unit = "bytes", reason = "promised" } # Kept too.
"cycles.a" = { figure = 10, limit = 10, unit = "cycles", reason = "promised" }
[[allowed]]
image = "a"
check = "panic"
through = "logger"
reason = "a test image"
"#;

fn standing(value: u64, compiler: &str) -> Standing {
    let judged = Budgets::parse(FILE).unwrap().judge(&[Figure::bytes("flash.a", value)], &["flash"], compiler);
    assert_eq!(judged.len(), 1);
    judged[0].standing
}

#[test]
fn a_figure_fails_above_its_limit_and_when_it_fell_by_more_than_a_twentieth() {
    for (value, expected) in [
        (121, Standing::Over),
        (120, Standing::Within),
        (100, Standing::Within),
        (95, Standing::Within),
        (94, Standing::Fell),
        (0, Standing::Fell),
    ] {
        assert_eq!(standing(value, "rustc 1"), expected, "{value}");
        assert_eq!(expected.fails(), expected != Standing::Within);
    }
}

#[test]
fn another_compiler_must_keep_the_limits_but_may_make_less() {
    assert_eq!(standing(94, "rustc 2"), Standing::FellElsewhere);
    assert!(!Standing::FellElsewhere.fails());
    assert_eq!(standing(121, "rustc 2"), Standing::Over);
}

#[test]
fn a_figure_without_budget_and_a_budget_without_figure_fail() {
    let budgets = Budgets::parse(FILE).unwrap();
    let judged = budgets.judge(&[Figure::bytes("flash.b", 1)], &["flash"], "rustc 1");
    let standings: Vec<_> = judged.iter().map(|figure| (figure.name.as_str(), figure.standing)).collect();
    assert_eq!(standings, [("flash.b", Standing::Unbudgeted), ("flash.a", Standing::Unmeasured)]);
    // A family that was not measured is left alone; one that was is not.
    assert_eq!(budgets.judge(&[], &["flash", "cycles"], "rustc 1").len(), 2);
    assert!(Standing::Unbudgeted.fails() && Standing::Unmeasured.fails());
}

#[test]
fn accepting_writes_what_was_measured_and_keeps_every_comment() {
    let budgets = Budgets::parse(FILE).unwrap();
    let judged = budgets.judge(&[Figure::bytes("flash.a", 50)], &["flash"], "rustc 2");
    let text = accepted(FILE, &judged, "rustc 2").unwrap();
    assert_eq!(text, FILE.replace("figure = 100", "figure = 50").replace("rustc 1", "rustc 2"));
    // What is over its limit is not accepted.
    let judged = budgets.judge(&[Figure::bytes("flash.a", 500)], &["flash"], "rustc 1");
    assert_eq!(accepted(FILE, &judged, "rustc 1").unwrap(), FILE);
}

#[test]
fn an_allowance_covers_its_image_its_check_and_its_way_only() {
    let budgets = Budgets::parse(FILE).unwrap();
    let finding = |check, through: &str| Finding {
        check,
        symbol: "core::panicking::panic".to_owned(),
        chain: vec!["main".to_owned(), through.to_owned()],
        held: false,
        note: String::new(),
    };
    let findings =
        [finding(Check::Panic, "logger::write"), finding(Check::Panic, "step"), finding(Check::Heap, "logger")];
    let (refused, idle) = budgets.sift("a", &findings);
    assert_eq!(refused, findings[1..]);
    assert!(idle.is_empty());
    let (refused, idle) = budgets.sift("b", &findings);
    assert_eq!((refused.len(), idle.len()), (3, 0));
    assert_eq!(budgets.sift("a", &[]).1.len(), 1);
}

#[test]
fn a_file_without_reasons_or_with_words_it_does_not_know_is_refused() {
    let refused = |from: &str, to: &str| Budgets::parse(&FILE.replace(from, to)).err().unwrap_or_default();
    assert!(refused("\"promised\"", "\" \"").contains("gives no reason"));
    assert!(
        refused("\"panic\"", "\"panics\"").contains("no check is called `panics`; there are heap, recursion, panic")
    );
    assert!(refused("figure = 100", "figure = 121").contains("above the limit"));
    assert!(refused("limit = 120", "limits = 120").contains("limits"));
}
