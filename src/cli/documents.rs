//! `orrery completions` and `orrery man`: generate shell completions and manual pages from clap's definitions.

use super::output::print_result;
use super::{Cli, CliError};
use clap::CommandFactory;

#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:
  orrery completions bash > ~/.local/share/bash-completion/completions/orrery
  orrery completions zsh > ~/.zfunc/_orrery
  orrery completions fish > ~/.config/fish/completions/orrery.fish")]
pub(crate) struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

#[derive(clap::Args, Debug)]
#[command(after_help = "Examples:
  orrery man > ~/.local/share/man/man1/orrery.1
  orrery man render | man -l -

The main page lists the commands; the page of a command describes its options.")]
pub(crate) struct ManArgs {
    /// Command that the page describes [default: the program, with a list of its commands]
    #[arg(value_name = "VERB")]
    verb: Option<String>,
}

pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "orrery", &mut script);
    print_result(&String::from_utf8_lossy(&script))
}

pub(crate) fn manual(args: &ManArgs) -> Result<(), CliError> {
    let mut command = Cli::command();
    command.build();
    let page = match &args.verb {
        None => command,
        Some(verb) => {
            let verbs: Vec<String> = command.get_subcommands().map(|v| v.get_name().to_owned()).collect();
            let known_verbs: Vec<&str> = verbs.iter().map(String::as_str).collect();
            let found = command.find_subcommand(verb.to_lowercase()).cloned();
            let unknown = || {
                CliError::Failed(format!(
                    "man {}: no such command; {}",
                    crate::wording::echo(verb),
                    crate::wording::suggestion_or_list(verb, &known_verbs)
                ))
            };
            let name = format!("orrery-{}", verb.to_lowercase());
            found.ok_or_else(unknown)?.display_name(name).version(env!("CARGO_PKG_VERSION"))
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .source(concat!("orrery ", env!("CARGO_PKG_VERSION")))
        .manual("Orrery")
        .render(&mut text)
        .map_err(|e| CliError::Failed(format!("the manual page: {e}")))?;
    print_result(&String::from_utf8_lossy(&text))
}
