//! Environment variables that switch something on: any value does, except 0 and the empty one.

pub fn is_on(variable: &str) -> bool {
    switches_on(std::env::var(variable).ok().as_deref())
}

fn switches_on(value: Option<&str>) -> bool {
    !matches!(value, None | Some("" | "0"))
}

#[test]
fn any_value_but_zero_switches_on() {
    assert_eq!([None, Some(""), Some("0"), Some("1"), Some("yes")].map(switches_on), [false, false, false, true, true]);
}
