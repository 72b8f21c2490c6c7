// Between the bytes of Python and what is stored in them.
#pragma once

#include <nanobind/nanobind.h>

#include "omnimorph/flight/stored_state.hpp"

namespace omnimorph::python {

namespace nb = nanobind;

inline nb::bytes stored_bytes(const StateHeader& header, const FlightState<double, 0>& state,
                              const DelayLine<double, 0>* delay_line) {
    const auto bytes = store(header, state, delay_line);
    return nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// What was stored, with the commands under way where there is a delay line; refuses what something else has stored.
inline FlightState<double, 0> stored_state(const nb::bytes& bytes, StateHeader expected,
                                           DelayLine<double, 0>* delay_line) {
    const auto* first = reinterpret_cast<const unsigned char*>(bytes.c_str());
    const std::string kind = name_of(expected.kind);
    FlightState<double, 0> state{};
    expected.has_delay_line = delay_line != nullptr;
    std::string why;
    switch (read_state({first, first + bytes.size()}, expected, state, delay_line)) {
        case Stored::read:
            return state;
        case Stored::of_another_version:
            why = "it was stored by another version of omnimorph";
            break;
        case Stored::of_another_kind:
            why = "it was not stored by a " + kind;
            break;
        case Stored::of_another_flight:
            why = "it is of another " + kind + ": rotors, servos, delay or time steps differ";
            break;
        case Stored::broken:
            why = "it is broken";
            break;
    }
    throw nb::value_error(why.c_str());
}

}  // namespace omnimorph::python
