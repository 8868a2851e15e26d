"""Parts of an accelerator: beam lines, magnets, vacuum, a source."""
