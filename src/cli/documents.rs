//! `orrery completions` and `orrery man`: generate shell completions and manual pages from clap's definitions.
//!
//! In: the name of a shell, or the words of a command. Out: a script or a page on standard output; nothing is installed.

use super::output::print_result;
use super::{Cli, CliError};
use crate::scene::draw::PixelView;
use crate::scene::effects::Effect;
use crate::scene::request::{Layers, ToneMap, UP_NAMES};
use crate::wording::{echo, suggestion_or_list};
use clap::builder::PossibleValuesParser;
use clap::{Arg, Command, CommandFactory, ValueHint};
use std::collections::BTreeSet;

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
  orrery man eclipse find | man -l -

The main page lists the commands; the page of a command describes its options.")]
pub(crate) struct ManArgs {
    /// Command that the page describes, such as `render` or `eclipse find` [default: the program, with a list of its commands]
    #[arg(value_name = "VERB")]
    verb: Vec<String>,
}

/// The names of a command's commands, of their commands, and so on.
fn names_below(command: &Command) -> Vec<String> {
    let of_one = |inner: &Command| [vec![inner.get_name().to_owned()], names_below(inner)].concat();
    command.get_subcommands().flat_map(of_one).collect()
}

/// The command for a completion script. Shells offer file names for a value of which clap knows nothing, so each value gets its words, or the hint that it is
/// or is not a file. The words of a list, such as `+orbits,-labels`, are completed for its first item. `verbs`: the words of `man`.
fn with_completed_values(command: Command, verbs: &BTreeSet<String>) -> Command {
    let completed = |arg: Arg| {
        let words = match arg.get_id().as_str() {
            "effects" => signed(&Effect::ALL.map(Effect::name)),
            "layers" => signed(&Layers::NAMES),
            "pixels" => PixelView::ALL.map(|view| view.name().to_owned()).to_vec(),
            "tone_map" => ToneMap::ALL.map(|tone_map| tone_map.name().to_owned()).to_vec(),
            "up" => UP_NAMES.map(str::to_owned).to_vec(),
            "verb" => verbs.iter().cloned().collect(),
            _ if !arg.get_action().takes_values() || arg.get_value_hint() != ValueHint::Unknown => return arg,
            _ if !arg.get_possible_values().is_empty() => return arg,
            _ => {
                let is_file = arg.get_value_names().unwrap_or_default().iter().any(|name| name.contains("FILE"));
                return arg.value_hint(if is_file { ValueHint::AnyPath } else { ValueHint::Other });
            }
        };
        arg.value_parser(PossibleValuesParser::new(words))
    };
    command.mut_args(completed).mut_subcommands(|inner| with_completed_values(inner, verbs))
}

/// Each name with `+` and with `-`.
fn signed(names: &[&str]) -> Vec<String> {
    names.iter().flat_map(|name| [format!("+{name}"), format!("-{name}")]).collect()
}

pub(crate) fn completions(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut command = Cli::command();
    // Without a command the options are those of `view`.
    let of_view: Vec<Arg> = command
        .find_subcommand("view")
        .map_or(Vec::new(), |view| view.get_arguments().filter(|arg| !arg.is_positional()).cloned().collect());
    command = command.args(of_view);
    let verbs = names_below(&command).into_iter().collect::<BTreeSet<_>>();
    let mut command = with_completed_values(command, &verbs);
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "orrery", &mut script);
    print_result(&String::from_utf8_lossy(&script))
}

/// The definition of the command that `words` name, such as `eclipse find`; without words, the definition of the program.
fn command_named(words: &[String]) -> Result<Command, CliError> {
    // A page does not list the command `help`, which has no page of its own.
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    let mut page_name = "orrery".to_owned();
    for word in words {
        let verb = word.to_lowercase();
        let Some(found) = command.find_subcommand(&verb).cloned() else {
            let known_verbs: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
            let hint = if known_verbs.is_empty() {
                format!("`{}` has no commands of its own", command.get_name())
            } else {
                suggestion_or_list(word, &known_verbs)
            };
            return Err(CliError::Usage(format!("man {}: no such command; {hint}", echo(&words.join(" ")))));
        };
        page_name = format!("{page_name}-{verb}");
        command = found.display_name(page_name.clone()).version(env!("CARGO_PKG_VERSION"));
    }
    Ok(command)
}

pub(crate) fn manual(args: &ManArgs) -> Result<(), CliError> {
    let page = command_named(&args.verb)?;
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .source(concat!("orrery ", env!("CARGO_PKG_VERSION")))
        .manual("Orrery")
        .render(&mut text)
        .map_err(|e| CliError::Failed(format!("the manual page: {e}")))?;
    print_result(&String::from_utf8_lossy(&text))
}
