//! What a module leaves to the Python that loads it is not looked for by the linker.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
