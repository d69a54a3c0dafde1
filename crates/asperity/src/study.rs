//! A study: configuration, run, results. The only module that knows the whole chain, and that writes files.
