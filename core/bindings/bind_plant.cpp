// The settings of a loop, and the plant by itself.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bind.hpp"
#include "bound_settings.hpp"
#include "flight_arrays.hpp"
#include "omnimorph/flight/simulated_plant.hpp"
#include "stored_bytes.hpp"

namespace omnimorph::python {

namespace {

/// A plant as Python has it, its rotors counted at run time.
struct BoundPlant {
    nb::object settings;  // whose tables it reads
    std::unique_ptr<SimulatedPlant<double, 0>> plant;
    SimulatedPlant<double, 0>* operator->() const { return plant.get(); }
};

BoundPlant new_plant(const nb::object& settings, std::uint64_t seed, std::uint32_t flight) {
    const AnyLoopSettings& s = nb::cast<const BoundSettings&>(settings).settings;
    return {settings, std::make_unique<SimulatedPlant<double, 0>>(s, NoiseKey{seed, flight})};
}

StateHeader header_of(const BoundPlant& p) {
    const AnyLoopSettings& s = nb::cast<const BoundSettings&>(p.settings).settings;
    StateHeader header;
    header.kind = StoredKind::plant;
    header.n_rotors = s.plant.vehicle.n_rotors;
    header.n_servos = s.plant.vehicle.n_servos;
    header.control_every = s.control_every;
    header.physics_step = s.plant.step;
    return header;
}

void restore(const BoundPlant& p, const nb::bytes& state) {
    if (p->delay_line() == nullptr) {
        p->restore(stored_state(state, header_of(p), nullptr), nullptr);
    } else {
        DelayLine<double, 0> delay_line;
        const FlightState<double, 0> x = stored_state(state, header_of(p), &delay_line);
        p->restore(x, &delay_line);
    }
}

std::size_t rotors_of(const BoundPlant& p) {
    return static_cast<std::size_t>(p->plant().n());
}
std::size_t servos_of(const BoundPlant& p) {
    return static_cast<std::size_t>(p->plant().m());
}

Vec6<double> load_of(const BoundPlant& p, int rotor) {
    if (rotor < 0 || rotor >= p->plant().n()) throw nb::value_error("the plant has no such rotor");
    return hub_load(p->plant(), p->state().actuators, rotor);
}

/// Speeds (steps, n) of all rotors and loads (steps, 6) of one hub, of a plant that is bolted down.
std::tuple<Numbers, Numbers> run_actuators(const BoundPlant& plant, int steps, int rotor) {
    const std::size_t rows = static_cast<std::size_t>(steps), n = rotors_of(plant);
    std::vector<double> speeds, loads;
    for (int k = 0; k < steps; ++k) {
        plant->advance_actuators();
        const double* speed = plant->state().actuators.speed.a;
        const auto load = load_of(plant, rotor);
        speeds.insert(speeds.end(), speed, speed + n);
        loads.insert(loads.end(), load.a, load.a + 6);
    }
    return {new_array(speeds.data(), {rows, n}), new_array(loads.data(), {rows, 6})};
}

}  // namespace

void bind_plant(nb::module_& m) {
    using namespace nb::literals;
    nb::class_<BoundSettings>(m, "LoopSettings")
        .def("__init__", &make_settings, "fields"_a)
        .def("places", [](const BoundSettings& s) {
            std::vector<std::tuple<std::string, std::size_t, bool>> all;
            for (const FieldPlace& place : places_in(s.settings))
                all.emplace_back(place.path, place.width, place.varies);
            return all;
        });
    nb::class_<BoundPlant>(m, "Plant")
        .def("measure", [](const BoundPlant& p) { return as_array(p->measure()); })
        .def(
            "send",
            [](const BoundPlant& p, const Array& thrust, const Array& tilt) {
                p->send(command_from(thrust, tilt, p->plant().n(), p->plant().m()));
            },
            "thrust"_a, "tilt"_a)
        .def(
            "advance",
            [](const BoundPlant& p, int steps, const Array& push) {
                expect_size(push, 6, "push");
                for (int k = 0; k < steps; ++k) p->advance(vector_from<6>(push.data()));
            },
            "steps"_a, "push"_a)
        .def("run_actuators", &run_actuators, "steps"_a, "rotor"_a)
        .def("motion", [](const BoundPlant& p) { return as_array(p->state().motion); })
        .def("speed", [](const BoundPlant& p) { return new_array(p->state().actuators.speed.a, {rotors_of(p)}); })
        .def("tilt", [](const BoundPlant& p) { return new_array(p->state().actuators.tilt.a, {servos_of(p)}); })
        .def("thrust",
             [](const BoundPlant& p) {
                 return new_array(thrust_actual(p->plant(), p->state().actuators).a, {rotors_of(p)});
             })
        .def("acceleration", [](const BoundPlant& p) { return new_array(p->acceleration().a, {6}); })
        .def("wrench", [](const BoundPlant& p) { return new_array(p->state().load.wrench.a, {6}); })
        .def("store", [](const BoundPlant& p) { return stored_bytes(header_of(p), p->stored(), p->delay_line()); })
        .def("restore", &restore, "state"_a)
        .def(
            "hub_load", [](const BoundPlant& p, int rotor) { return new_array(load_of(p, rotor).a, {6}); }, "rotor"_a)
        .def_prop_ro("step", [](const BoundPlant& p) { return p->step(); });
    m.def("new_plant", &new_plant, nb::kw_only(), "settings"_a, "seed"_a, "flight"_a);
}

}  // namespace omnimorph::python
