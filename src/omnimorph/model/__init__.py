"""The documented face of the core's model: wrench maps (`allocation`) and rigid body (`dynamics`)."""
