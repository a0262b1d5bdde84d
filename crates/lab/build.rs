//! Records the version of the compiler that builds the lab crate. The captions of the charts quote
//! this version.

use std::process::Command;

fn main() {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let version = Command::new(rustc).arg("--version").output();
    let version = version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    let version = version.unwrap_or_else(|_| "an unknown compiler".into());
    println!("cargo::rustc-env=LAB_RUSTC={version}");
    println!("cargo::rerun-if-changed=build.rs");
}
