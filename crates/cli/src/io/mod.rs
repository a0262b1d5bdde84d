//! Input and output: the formats of answers, the pipeline that produces them, files, signals and
//! progress bars.

pub(crate) mod answers;
pub(crate) mod numbers;
pub(crate) mod output;
pub(crate) mod pipeline;
pub(crate) mod pipes;
pub(crate) mod progress;
pub(crate) mod same_file;
pub(crate) mod signals;
pub(crate) mod standard_output;
