fn main() -> std::process::ExitCode {
    orrery::cli::run()
}
