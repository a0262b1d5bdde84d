#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| intertri_tests::fuzz::instances(bytes));
