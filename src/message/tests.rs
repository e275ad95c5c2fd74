//! Tests of the English texts.

#[test]
fn texts_are_those_of_the_file_with_their_arguments() {
    let limit = reason!("of-white", light = format_args!("{:.2e}", 0.001), least = 2);
    let both = reason!("inside-sun").and(reason!("eclipse-at-most", light = limit));
    assert_eq!(both.to_string(), "it is inside the Sun; at most 1.00e-3 of white against 2");
    assert_eq!(serde_json::to_string(&both).expect("JSON"), "\"it is inside the Sun; at most 1.00e-3 of white against 2\"");
    let names = reason!("eclipse-penumbra-of", bodies = vec!["Io".to_owned(), "Europa".to_owned()]);
    assert_eq!(names.to_string(), "penumbra of Io, Europa on its lit side");
    // What a test would find is still written.
    assert_eq!(message!("nobody-wrote-this").to_string(), "nobody-wrote-this");
    assert_eq!(message!("reason-of-white", light = 1).to_string(), "1 of white against least");
}
