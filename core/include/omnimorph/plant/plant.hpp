// The plant: actuators with their imperfections, then the rigid body, one physics step at a time.
//
// The angular state of the integrators is the whole angular momentum in B, L = J w + H, with H = sum I_i k_i w_i z_i that of
// the spinning rotors (zero unless the effect RotorMomentum is on). dL/dt = tau - w x L then holds the gyroscopic torque, the
// reaction to spinning up and the torque of tilting a spinning rotor at once, without a derivative of any of them.
#pragma once

#include "command_delay.hpp"
#include "dead_band.hpp"
#include "disturbance.hpp"
#include "../estimate/measurement_noise.hpp"
#include "rotor_lag.hpp"
#include "servo.hpp"
#include "speed_limits.hpp"
#include "../model/interference.hpp"
#include "../model/wrench.hpp"

namespace omnimorph {

enum class Integrator { semi_implicit_euler, runge_kutta_4 };

/// Everything about the plant that a flight does not change.
template <class T, int N> struct PlantSettings {
    Vehicle<T, N> vehicle;                    // the true one
    PerRotor<T, N> command_coefficient;       // c_f by which the motor drivers turn thrust into speed: the controller's
    PerRotor<T, N> effectiveness;             // share of its thrust that each rotor still gives
    double step;                              // s
    Integrator integrator = Integrator::semi_implicit_euler;
    int delay_steps = 0;
    bool rotor_momentum = false;
    bool interference = false;                // rotors in line take thrust from one another
    WakeModel wake_model = WakeModel::published;
    SpeedLimits<T, N> speed_limits;
    DeadBand<T, N> dead_band;
    RotorLag<T, N> rotor_lag;
    ServoLag<T> servo_lag;
    ServoRateLimit<T> servo_rate_limit;
    MeasurementNoise<T> measurement_noise;
    Disturbance<T> disturbance;
    explicit PlantSettings(int n = N) : vehicle{} { vehicle.n_rotors = Count<N>(n); }

    /// The same plant for another number type or rotor count.
    template <class S, int M> explicit PlantSettings(const PlantSettings<S, M>& other)
        : vehicle(convert<Vehicle<T, N>>(other.vehicle)),
          command_coefficient(cast<T, N>(other.command_coefficient, other.vehicle.n_rotors)),
          effectiveness(cast<T, N>(other.effectiveness, other.vehicle.n_rotors)),
          step(other.step),
          integrator(other.integrator),
          delay_steps(other.delay_steps),
          rotor_momentum(other.rotor_momentum),
          interference(other.interference),
          wake_model(other.wake_model),
          speed_limits(other.speed_limits, other.vehicle.n_rotors),
          dead_band(other.dead_band, other.vehicle.n_rotors),
          rotor_lag(other.rotor_lag, other.vehicle.n_rotors),
          servo_lag(other.servo_lag, other.vehicle.n_servos),
          servo_rate_limit(other.servo_rate_limit, other.vehicle.n_servos),
          measurement_noise(other.measurement_noise),
          disturbance(other.disturbance) {}

    /// The integrator's steps of the actuators: Runge and Kutta need them in the middle too.
    double actuator_step() const { return integrator == Integrator::runge_kutta_4 ? step / 2 : step; }
};

/// Actual speeds and tilts.
template <class T, int N> struct Actuators {
    PerRotor<T, N> speed;      // rad/s
    PerRotor<T, N> rest_left;  // s, see DeadBand
    PerServo<T> tilt;          // rad
};

/// The wrench in B, and the rotors' own angular momentum in B.
template <class T> struct Load {
    Vec6<T> wrench;
    Vec3<T> momentum;
};

template <class T, int N> class Plant {
  public:
    Motion<T> motion;
    Actuators<T, N> actuators;

    Plant(const PlantSettings<T, N>& settings, const Motion<T>& start, const Command<T, N>& command)
        : motion(start), settings_(settings), inverse_mass_(T(1) / settings.vehicle.mass), map_(speed_map(settings, settings.vehicle.drag_coefficient)),
          thrust_map_(speed_map(settings, PerRotor<T, N>{})), wakes_(settings.vehicle, settings.wake_model), delay_(settings.delay_steps, command) {
        for (int i = 0; i < n(); ++i) {
            speed_squared_per_thrust_[i] = T(1) / settings.command_coefficient[i];
            actuators.speed[i] = speed_for(i, command.thrust[i]);
            actuators.rest_left[i] = T(0);
        }
        actuators.tilt = command.tilt;
        load_ = load(actuators);
    }

    void send(long step, const Command<T, N>& command) { delay_.send(step, command); }
    const Command<T, N>& in_force(long step) { return delay_.in_force(step); }

    /// The wrench that the actuators make now.
    const Vec6<T>& wrench_achieved() const { return load_.wrench; }

    /// The thrust that each rotor gives along its axis now, N: at its actual speed, of its share of effectiveness, and what
    /// the wakes of others leave of it.
    PerRotor<T, N> thrust_actual() const {
        PerRotor<T, N> thrust{};
        for (int i = 0; i < n(); ++i) {
            const T coefficient = settings_.effectiveness[i] * settings_.vehicle.thrust_coefficient[i];
            thrust[i] = coefficient * (actuators.speed[i] * abs(actuators.speed[i]));
        }
        if (!settings_.interference) return thrust;
        const PerRotor<T, N> kept = wakes_.thrust_kept(wakes_.weights(trigonometry_of(actuators.tilt, settings_.vehicle.n_servos)), actuators.speed);
        for (int i = 0; i < n(); ++i) thrust[i] = kept[i] * thrust[i];
        return thrust;
    }

    /// One physics step under the command in force and a disturbance from outside (force in W, torque in B).
    void advance(long step, const Vec6<T>& pushed) {
        const Command<T, N>& command = in_force(step);
        if (settings_.integrator == Integrator::semi_implicit_euler) {
            semi_implicit_euler(step, command, pushed);
        } else {
            runge_kutta_4(step, command, pushed);
        }
        if (step % 1024 == 1023) motion.R = projected(motion.R);
    }

    const PlantSettings<T, N>& settings() const { return settings_; }

    /// From now on each rotor gives this share of its thrust; its drag torque stays, as with a torn blade.
    void set_effectiveness(const PerRotor<T, N>& share) {
        settings_.effectiveness = share;
        map_ = speed_map(settings_, settings_.vehicle.drag_coefficient);
        thrust_map_ = speed_map(settings_, PerRotor<T, N>{});
        load_ = load(actuators);
    }

  private:
    /// Rates of change of position, velocity, attitude (in the Lie algebra) and angular momentum.
    struct Rates {
        Vec3<T> p, v, attitude, L;
    };

    int n() const { return settings_.vehicle.n_rotors; }

    static WrenchMap<T, N> speed_map(const PlantSettings<T, N>& settings, const PerRotor<T, N>& drag) {
        PerRotor<T, N> thrust{};
        for (int i = 0; i < settings.vehicle.n_rotors; ++i)
            thrust[i] = settings.effectiveness[i] * settings.vehicle.thrust_coefficient[i];
        return WrenchMap<T, N>(settings.vehicle, thrust, drag);
    }

    T speed_for(int i, const T& thrust) const {
        return with_sign(sqrt(abs(thrust) * speed_squared_per_thrust_[i]), thrust);
    }

    /// Command -> limits -> dead band -> lag; servo lag -> rate limit -> stops. With `time_passes` by one actuator step,
    /// without it only what follows a new command at once.
    void advance_actuators(Actuators<T, N>& a, const Command<T, N>& command, bool time_passes) const {
        const T step = T(time_passes ? settings_.actuator_step() : 0.0);
        for (int i = 0; i < n(); ++i) {
            const T asked = settings_.speed_limits.apply(i, speed_for(i, command.thrust[i]));
            const T aim = settings_.dead_band.aim(i, asked, a.speed[i], a.rest_left[i], step);
            a.speed[i] = settings_.rotor_lag.advance(i, a.speed[i], aim, time_passes);
        }
        const Vehicle<T, N>& vehicle = settings_.vehicle;
        for (int j = 0; j < vehicle.n_servos; ++j) {
            const T way = settings_.servo_lag.travel(j, command.tilt[j] - a.tilt[j], time_passes);
            const T target = a.tilt[j] + settings_.servo_rate_limit.travel(j, way, time_passes);
            a.tilt[j] = clamp(target, vehicle.angle_min[j], vehicle.angle_max[j]);
        }
    }

    Load<T> load(const Actuators<T, N>& a) const {
        const Vehicle<T, N>& vehicle = settings_.vehicle;
        const auto trig = trigonometry_of(a.tilt, vehicle.n_servos);
        PerRotor<T, N> squared;
        for (int i = 0; i < n(); ++i) squared[i] = a.speed[i] * abs(a.speed[i]);
        Load<T> out{wrench(map_.at(trig), squared, n()), Vec3<T>::zero()};
        if (settings_.interference) out.wrench = out.wrench - wrench_lost(trig, a.speed, squared);
        if (settings_.rotor_momentum)
            for (int i = 0; i < n(); ++i)
                out.momentum = out.momentum + (vehicle.spin_inertia[i] * vehicle.spin[i] * a.speed[i]) * rotor_axis(vehicle, i, trig);
        return out;
    }

    /// What the wakes take: the thrust alone, the drag torque stays.
    Vec6<T> wrench_lost(const TiltTrigonometry<T>& trig, const PerRotor<T, N>& speed, const PerRotor<T, N>& squared) const {
        const PerRotor<T, N> kept = wakes_.thrust_kept(wakes_.weights(trig), speed);
        PerRotor<T, N> lost{};
        for (int i = 0; i < n(); ++i) lost[i] = (T(1) - kept[i]) * squared[i];
        return wrench(thrust_map_.at(trig), lost, n());
    }

    Vec6<T> disturbance(double time, const Vec6<T>& pushed) const {
        return settings_.disturbance.active ? pushed + settings_.disturbance.at(time) : pushed;
    }

    Vec3<T> linear_acceleration(const Mat3<T>& R, const Vec6<T>& rotors, const Vec6<T>& push) const {
        Vec3<T> a = inverse_mass_ * (R * force_of(rotors) + force_of(push));
        a[2] -= T(gravity);
        return a;
    }

    /// New velocities from the present pose and the new actuators, then the pose from the new velocities (as ODE does).
    void semi_implicit_euler(long step, const Command<T, N>& command, const Vec6<T>& pushed) {
        const T h = T(settings_.step);
        const Vehicle<T, N>& vehicle = settings_.vehicle;
        Vec3<T> L = vehicle.inertia * motion.w + load_.momentum;
        advance_actuators(actuators, command, true);
        load_ = load(actuators);
        const Vec6<T> push = disturbance(double(step) * settings_.step, pushed);
        motion.v = motion.v + h * linear_acceleration(motion.R, load_.wrench, push);
        motion.p = motion.p + h * motion.v;
        L = L + h * (torque_of(load_.wrench) + torque_of(push) - cross(motion.w, L));
        motion.w = vehicle.inertia_inverse * (L - load_.momentum);
        motion.R = motion.R * exp_so3(h * motion.w);
    }

    /// Classical fourth order, the attitude in the Lie algebra (H. Munthe-Kaas, BIT 38, 1998); the actuators are advanced
    /// exactly to the middle and to the end of the step.
    void runge_kutta_4(long step, const Command<T, N>& command, const Vec6<T>& pushed) {
        const double h = settings_.step, time = double(step) * h;
        const Vec3<T> L = settings_.vehicle.inertia * motion.w + load_.momentum;
        advance_actuators(actuators, command, false);
        const Load<T> at_start = load(actuators);
        advance_actuators(actuators, command, true);
        const Load<T> at_middle = load(actuators);
        advance_actuators(actuators, command, true);
        load_ = load(actuators);  // at the end
        const Vec6<T> push_start = disturbance(time, pushed), push_middle = disturbance(time + h / 2, pushed);

        const Rates start{Vec3<T>::zero(), Vec3<T>::zero(), Vec3<T>::zero(), Vec3<T>::zero()};
        const Rates k1 = rates(start, 0, L, at_start, push_start);
        const Rates k2 = rates(k1, h / 2, L, at_middle, push_middle);
        const Rates k3 = rates(k2, h / 2, L, at_middle, push_middle);
        const Rates k4 = rates(k3, h, L, load_, disturbance(time + h, pushed));
        const auto change = [&](Vec3<T> Rates::*of) {
            return T(h / 6) * (k1.*of + T(2) * (k2.*of) + T(2) * (k3.*of) + k4.*of);
        };
        motion.p = motion.p + change(&Rates::p);
        motion.v = motion.v + change(&Rates::v);
        motion.R = motion.R * exp_so3(change(&Rates::attitude));
        motion.w = settings_.vehicle.inertia_inverse * (L + change(&Rates::L) - load_.momentum);
    }

    /// Rates of change after going on from the present motion for `share` seconds along `k`.
    Rates rates(const Rates& k, double share, const Vec3<T>& L_start, const Load<T>& rotors, const Vec6<T>& push) const {
        const T h = T(share);
        const Vec3<T> attitude = h * k.attitude, L = L_start + h * k.L;
        const Vec3<T> w = settings_.vehicle.inertia_inverse * (L - rotors.momentum);
        return {motion.v + h * k.v, linear_acceleration(motion.R * exp_so3(attitude), rotors.wrench, push),
                exp_so3_rate(attitude, w), torque_of(rotors.wrench) + torque_of(push) - cross(w, L)};
    }

    PlantSettings<T, N> settings_;
    Load<T> load_;  // of the actuators as they are
    T inverse_mass_;
    PerRotor<T, N> speed_squared_per_thrust_;  // 1/c_f of the motor drivers
    WrenchMap<T, N> map_;          // signed squared speeds -> wrench
    WrenchMap<T, N> thrust_map_;   // the same without drag
    Interference<T, N> wakes_;
    CommandDelay<T, N> delay_;
};

}  // namespace omnimorph
