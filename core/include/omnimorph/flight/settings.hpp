// The settings of a flight, stage by stage.
#pragma once

#include "../control/allocation.hpp"
#include "../control/track.hpp"
#include "../estimate/estimator.hpp"
#include "../plant/plant.hpp"

namespace omnimorph {

template <class T, int N> struct ControllerSettings {
    Vehicle<T, N> model;  // the vehicle as the controller believes it to be
    TrackingSettings<T> tracking;
    AllocationSettings<T, N> allocation;
    double period = 0;  // of control, s

    static constexpr auto fields() {
        using S = ControllerSettings;
        return field_list(field("model", &S::model), field("tracking", &S::tracking),
                          field("allocation", &S::allocation), field("period", &S::period));
    }
};

template <int N> void derive(ControllerSettings<double, N>& s) {
    derive(s.model);
    s.tracking.position_first.mass = s.model.mass;
    s.tracking.position_first.period = s.period;
}

/// Where a flight begins, and the command that is in force there.
template <class T, int N> struct FlightStart {
    Motion<T> motion;
    Command<T, N> command;

    static constexpr auto fields() {
        return field_list(field("motion", &FlightStart::motion), field("command", &FlightStart::command));
    }
};

template <class T, int N> struct LoopSettings {
    ControllerSettings<T, N> controller;
    Sensors<T> sensors;
    Estimator<T> estimator;
    PlantSettings<T, N> plant;
    FlightStart<T, N> start;
    int control_every = 1;      // physics steps between control steps
    double control_period = 0;  // s

    static constexpr auto fields() {
        using S = LoopSettings;
        return field_list(field("controller", &S::controller), field("sensors", &S::sensors),
                          field("estimator", &S::estimator), field("plant", &S::plant), field("start", &S::start),
                          field("control_every", &S::control_every), field("control_period", &S::control_period));
    }
};

/// Set what follows from the other fields.
template <int N> void derive(LoopSettings<double, N>& s) {
    derive(s.controller);
    std::visit([&](auto& estimator) { derive(estimator, s.control_period); }, s.estimator);
    for_each(s.sensors, [](auto& sensor) {
        static_assert(!fields::has_derived<std::decay_t<decltype(sensor)>>, "nothing derives the fields of sensors");
    });
    derive(s.plant);
}

}  // namespace omnimorph
