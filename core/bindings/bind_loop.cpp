// The controller, and the flight: all in the core, or one control step or physics step at a time.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "bind.hpp"
#include "flight_arrays.hpp"
#include "rotor_counts.hpp"

namespace omnimorph::python {

namespace {

using Settings = ControllerSettings<double, 0>;

/// The rules as Python names them.
enum class RuleName { fixed_tilt, best_in_window, towards_best_in_range, jointly };

AllocationRule<double> rule_from(RuleName rule, int candidates, double tilt_change_weight) {
    switch (rule) {
        case RuleName::fixed_tilt: return FixedTilt{};
        case RuleName::best_in_window: return TiltCandidates{TiltSpan::window, candidates};
        case RuleName::towards_best_in_range: return TiltCandidates{TiltSpan::range, candidates};
        case RuleName::jointly: break;
    }
    return JointTilt<double>{tilt_change_weight};
}

Settings make_controller_settings(const AnyVehicle& vehicle, const Array& velocity, const Array& position, const Array& rate, const Array& attitude,
                                  const Array& input, const Array& input_change, const Array& acceleration, RuleName rule, const Array& tilt_change,
                                  int candidates, double tilt_change_weight, std::optional<double> lateral_force, double control_period) {
    for (const Array* gain : {&velocity, &position, &rate, &attitude}) expect_size(*gain, 3, "gain");
    expect_size(acceleration, 6, "acceleration");
    const bool searches = rule == RuleName::best_in_window || rule == RuleName::towards_best_in_range;
    if (searches && vehicle.n_servos != 1) throw nb::value_error("a rule that tries tilts needs exactly one servo");
    if (searches && (candidates < 3 || candidates % 2 == 0)) throw nb::value_error("candidates are odd and three or more");
    Settings s;
    s.gains = {vector_from<3>(velocity.data()), vector_from<3>(position.data()), vector_from<3>(rate.data()), vector_from<3>(attitude.data())};
    s.allocation.weights = {per_rotor_from(input, vehicle.n_rotors, "input"), per_rotor_from(input_change, vehicle.n_rotors, "input_change"),
                 vector_from<6>(acceleration.data())};
    s.allocation.tilt_change = per_servo_from(tilt_change, vehicle.n_servos, "tilt_change");
    s.allocation.rule = rule_from(rule, candidates, tilt_change_weight);
    if (lateral_force) s.position_first = PositionFirst<double>(*lateral_force, vehicle.mass, control_period);
    return s;
}

/// An allocation as Python sees it; it knows how many rotors and servos it speaks of.
struct AllocationView {
    AnyAllocation a;
    int n, m;
};

/// A controller as Python has it: behind a pointer, as it is aligned more strictly than who holds it can know.
struct BoundController {
    std::unique_ptr<AnyController> controller;
    AnyController* operator->() const { return controller.get(); }
};

/// A flight in the same way, with what it reads and writes; in one thread at a time.
struct BoundFlight {
    nb::object reference;
    std::shared_ptr<Columns> columns;  // none, if it is not recorded
    std::unique_ptr<AnyFlight> flight;
    bool is_away = false;  // flown while other threads of Python go on
    AnyFlight* operator->() const {
        if (is_away) throw std::runtime_error("the flight is being flown in another thread");
        return flight.get();
    }
};

void advance(BoundFlight& f, long most_steps) {
    AnyFlight* const flight = f.operator->();
    f.is_away = true;
    {
        const nb::gil_scoped_release others_go_on;
        flight->advance(most_steps);
    }
    f.is_away = false;
}

/// Thrusts (K, n) and tilts (K, m) of K control steps, one after the other.
std::tuple<Numbers, Numbers> replayed(const BoundController& controller, const Array& states, const Array& desired) {
    const std::size_t K = states.size() / state_width, n = static_cast<std::size_t>(controller->n_rotors), m = static_cast<std::size_t>(controller->n_servos);
    expect_size(states, K * state_width, "states");
    expect_size(desired, K * desired_width, "desired");
    std::vector<Motion<double>> measured;
    std::vector<Desired<double>> wished;
    for (std::size_t k = 0; k < K; ++k) {
        measured.push_back(motion_from(states.data() + k * state_width));
        wished.push_back(desired_from(desired.data() + k * desired_width));
    }
    std::vector<double> thrust(K * n), tilt(K * m);
    controller->replay(K, measured.data(), wished.data(), thrust.data(), tilt.data());
    return {new_array(thrust.data(), {K, n}), new_array(tilt.data(), {K, m})};
}

/// Costs (S, K) of S control steps at K tilts each.
Numbers costs_over_tilt(const AnyVehicle& vehicle, const Settings& settings, const Array& states, const Array& accelerations, const Array& previous_thrusts,
                        const Array& tilts) {
    if (tilts.ndim() != 2 || vehicle.n_servos != 1) throw nb::value_error("cost_over_tilt takes rows of tilts of a single servo");
    const std::size_t S = tilts.shape(0), K = tilts.shape(1), n = static_cast<std::size_t>(int(vehicle.n_rotors));
    expect_size(states, S * state_width, "states");
    expect_size(accelerations, S * 6, "accelerations");
    expect_size(previous_thrusts, S * n, "previous_thrusts");
    std::vector<ControlStep> steps(S);
    for (std::size_t k = 0; k < S; ++k) {
        steps[k] = {motion_from(states.data() + k * state_width), vector_from<6>(accelerations.data() + k * 6), {}};
        for (std::size_t i = 0; i < n; ++i) steps[k].previous_thrust[int(i)] = previous_thrusts.data()[k * n + i];
    }
    const auto costs = with_rotors(vehicle.n_rotors, [&](auto rotors) { return cost_over_tilt<rotors>(vehicle, settings.allocation.weights, steps, tilts.data(), K); });
    return new_array(costs.data(), {S, K});
}

BoundController new_controller(const AnyVehicle& vehicle, const Settings& settings, const Array& thrust, const Array& tilt) {
    const AnyCommand start = command_from(thrust, tilt, vehicle.n_rotors, vehicle.n_servos);
    return {with_rotors(vehicle.n_rotors, [&](auto rotors) { return make_controller<rotors>(vehicle, settings, start); })};
}

BoundFlight new_flight(const PlantSettings<double, 0>& plant, const AnyVehicle& model, const Settings& controller, const nb::object& reference,
                       const Array& start, const Array& thrust, const Array& tilt, long steps, int control_every, double lost_beyond, std::uint64_t seed,
                       std::uint32_t flight, bool is_recorded) {
    const int n = model.n_rotors, m = model.n_servos;
    expect_times(steps, control_every, is_recorded);
    BoundFlight bound{reference, {}, {}};
    if (is_recorded) bound.columns = std::make_shared<Columns>(static_cast<std::size_t>(steps + 1), n, m);
    const FlightParts parts{plant, model, controller, nb::cast<const Reference*>(reference), motion_from(start), command_from(thrust, tilt, n, m),
                            {steps, control_every, lost_beyond, {seed, flight}}, is_recorded ? bound.columns->record() : Record()};
    bound.flight = with_rotors(n, [&](auto rotors) { return make_flight<rotors>(parts); });
    return bound;
}

void make_reference(Reference* self, const Array& segments, const Array& samples) {
    new (self) Reference();
    if (segments.size() % 21 != 0 || samples.size() % desired_width != 0 || segments.size() + samples.size() == 0)
        throw nb::value_error("a reference has rows of 21 (segments) or 24 numbers (samples)");
    for (std::size_t k = 0; k < segments.size(); k += 21) {
        const double* row = segments.data() + k;
        self->segments.push_back({row[0], row[1], vector_from<3>(row + 2), vector_from<3>(row + 5), matrix_from(row + 8), vector_from<3>(row + 17), row[20]});
    }
    self->samples.assign(samples.data(), samples.data() + samples.size());
}

/// Send a command that was decided outside; false, and the end of the flight, if a number of it is not finite.
bool decide(const BoundFlight& flight, const Array& thrust, const Array& tilt, const Array& wrench_asked) {
    expect_size(wrench_asked, 6, "wrench_asked");
    AnyAllocation a{command_from(thrust, tilt, flight->n_rotors, flight->n_servos), {}, std::nan(""), std::nan(""), vector_from<6>(wrench_asked.data())};
    double sum = 0;
    for (int j = 0; j < flight->n_servos; ++j) sum += a.command.tilt[j];
    for (int i = 0; i < flight->n_rotors; ++i) {
        const double f = a.command.thrust[i];
        sum += f;
        a.active[i] = f >= flight->thrust_max[i] ? 1.0 : (f <= flight->thrust_min[i] ? -1.0 : 0.0);
    }
    if (is_finite(sum)) {
        flight->decide(a);
    } else {
        flight->refuse_command();
    }
    return is_finite(sum);
}

}  // namespace

void bind_loop(nb::module_& m) {
    using namespace nb::literals;
    nb::enum_<RuleName>(m, "AllocationRule")
        .value("FIXED_TILT", RuleName::fixed_tilt)
        .value("BEST_IN_WINDOW", RuleName::best_in_window)
        .value("TOWARDS_BEST_IN_RANGE", RuleName::towards_best_in_range)
        .value("JOINTLY", RuleName::jointly);
    nb::class_<Settings>(m, "ControllerSettings");
    m.def("make_controller_settings", &make_controller_settings, "vehicle"_a, nb::kw_only(), "velocity"_a, "position"_a, "rate"_a, "attitude"_a, "input"_a,
          "input_change"_a, "acceleration"_a, "rule"_a, "tilt_change"_a, "candidates"_a, "tilt_change_weight"_a, "lateral_force"_a.none(),
          "control_period"_a);
    nb::class_<AllocationView>(m, "Allocation")
        .def_prop_ro("thrust", [](const AllocationView& v) { return view_of(v.a.command.thrust.a, v.n); })
        .def_prop_ro("tilt", [](const AllocationView& v) { return view_of(v.a.command.tilt.a, v.m); })
        .def_prop_ro("active", [](const AllocationView& v) { return view_of(v.a.active.a, v.n); })
        .def_prop_ro("wrench_asked", [](const AllocationView& v) { return view_of(v.a.wrench_asked.a, 6); })
        .def_prop_ro("cost", [](const AllocationView& v) { return v.a.cost; })
        .def_prop_ro("kkt_residual", [](const AllocationView& v) { return v.a.kkt_residual; });
    nb::class_<BoundController>(m, "Controller")
        .def("step", [](const BoundController& c, const Array& state, const Array& desired) {
            return AllocationView{c->step(motion_from(state), desired_from(desired)), c->n_rotors, c->n_servos};
        }, "state"_a, "desired"_a)
        .def("allocate", [](const BoundController& c, const Array& state, const Array& acceleration) {
            expect_size(acceleration, 6, "acceleration");
            return AllocationView{c->allocate(motion_from(state), vector_from<6>(acceleration.data())), c->n_rotors, c->n_servos};
        }, "state"_a, "acceleration"_a)
        .def("replay", &replayed, "states"_a, "desired"_a);
    m.def("new_controller", &new_controller, "vehicle"_a, "settings"_a, "thrust"_a, "tilt"_a);
    m.def("cost_over_tilt", &costs_over_tilt, "vehicle"_a, "settings"_a, "states"_a, "accelerations"_a, "previous_thrusts"_a, "tilts"_a);
    m.def("reference_acceleration", [](const Settings& s, const Array& state, const Array& desired) {
        return new_array(reference_acceleration(motion_from(state), desired_from(desired), s.gains).a, {6});
    }, "settings"_a, "state"_a, "desired"_a);
    m.def("wrench_for", [](const AnyVehicle& v, const Array& state, const Array& acceleration) {
        expect_size(acceleration, 6, "acceleration");
        return new_array(wrench_for(v, motion_from(state), vector_from<6>(acceleration.data())).a, {6});
    }, "vehicle"_a, "state"_a, "acceleration"_a);

    nb::class_<Reference>(m, "Reference").def("__init__", &make_reference, "segments"_a, "samples"_a);

    nb::enum_<FlightStatus>(m, "FlightStatus")
        .value("FLYING", FlightStatus::flying)
        .value("COMPLETED", FlightStatus::completed)
        .value("LOST", FlightStatus::lost)
        .value("NOT_FINITE", FlightStatus::not_finite)
        .value("DIVERGED", FlightStatus::diverged);
    nb::class_<BoundFlight>(m, "Flight")
        .def("advance", &advance, "most_steps"_a)
        .def("measure", [](const BoundFlight& f) { return as_array(f->measure()); })
        .def("motion", [](const BoundFlight& f) { return as_array(f->motion()); })
        .def("desired", [](const BoundFlight& f) { return as_array(f->desired()); })
        .def("control", [](const BoundFlight& f, const Array& state, const Array& desired) {
            return AllocationView{f->control(motion_from(state), desired_from(desired)), f->n_rotors, f->n_servos};
        }, "state"_a, "desired"_a)
        .def("decide", &decide, "thrust"_a, "tilt"_a, "wrench_asked"_a)
        .def("change_controller", [](const BoundFlight& f, const Settings& settings) { f->change_controller(settings); }, "settings"_a)
        .def("set_effectiveness", [](const BoundFlight& f, const Array& share) {
            f->set_effectiveness(per_rotor_from(share, f->n_rotors, "share"));
        }, "share"_a)
        .def("integrate", [](const BoundFlight& f, int steps, const Array& pushed) {
            expect_size(pushed, 6, "pushed");
            f->integrate(steps, vector_from<6>(pushed.data()));
        }, "steps"_a, "pushed"_a)
        .def("speed", [](const BoundFlight& f) { return new_array(f->speed().a, {static_cast<std::size_t>(f->n_rotors)}); })
        .def("tilt", [](const BoundFlight& f) { return new_array(f->tilt().a, {static_cast<std::size_t>(f->n_servos)}); })
        .def("wrench_achieved", [](const BoundFlight& f) { return new_array(f->wrench_achieved().a, {6}); })
        .def("columns", [](const BoundFlight& f) { return f.columns ? Columns::arrays(f.columns) : nb::dict(); })
        .def_prop_ro("step", [](const BoundFlight& f) { return f->step(); })
        .def_prop_ro("status", [](const BoundFlight& f) { return f->status(); });
    m.def("new_flight", &new_flight, nb::kw_only(), "plant"_a, "model"_a, "controller"_a, "reference"_a, "start"_a, "thrust"_a, "tilt"_a,
          "steps"_a, "control_every"_a, "lost_beyond"_a, "seed"_a, "flight"_a, "is_recorded"_a);
}

}  // namespace omnimorph::python
