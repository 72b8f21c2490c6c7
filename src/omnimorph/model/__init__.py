"""The documented face of the core's model: wrenches (`allocation`), rigid body (`dynamics`)."""
