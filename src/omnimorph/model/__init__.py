"""The documented face of the core's model: wrenches (`allocation`), `dynamics`, `interference`."""
