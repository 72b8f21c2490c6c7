// The settings of a loop as Python holds them, with the tables that they point to.
#pragma once

#include "loop.hpp"
#include "records.hpp"

namespace omnimorph::python {

struct BoundSettings {
    AnyLoopSettings settings{};
    Tables tables;
};

/// From a dict of every field; the vehicle of the plant is one that was made before, and holds the
/// rotor count.
inline void make_settings(BoundSettings* self, const nb::dict& fields) {
    new (self) BoundSettings();
    const auto& truth = nb::cast<const AnyVehicle&>(nb::cast<nb::dict>(fields["plant"])["vehicle"]);
    RecordReader(truth.n_rotors, truth.n_servos, self->tables).read(self->settings, fields, "settings");
    derive(self->settings);
}

}  // namespace omnimorph::python
