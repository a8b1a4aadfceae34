//! The command `pitchid`.

fn main() -> std::process::ExitCode {
    pitchid::main()
}
