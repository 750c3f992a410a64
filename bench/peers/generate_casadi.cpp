// Pinocchio's algorithms traced by CasADi, as C.
//
//     generate_casadi ARM FOLDER     writes FOLDER/casadi_{inverse,kernel,forward}_{f64,f32}.c
//
// `inverse` and `forward` take angles; `kernel` is the inverse dynamics with cosines and sines for inputs.
#define PINOCCHIO_ARM
#include <pinocchio/autodiff/casadi.hpp>
#include "arm.hpp"
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

using Scalar = casadi::SX;
using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

static Vector input(const casadi::SX &symbols) {
    Vector vector(symbols.size1());
    for (int i = 0; i < vector.size(); ++i)
        vector[i] = symbols(i);
    return vector;
}

template <class Axis>
static void generate(const Arm &arm, const std::string &folder, const std::string &name) {
    auto model = pinocchio_arm<Axis>(arm).template cast<Scalar>();
    typename decltype(model)::Data data(model);
    auto q = casadi::SX::sym("q", model.nq), qd = casadi::SX::sym("qd", model.nv), third = casadi::SX::sym("x", model.nv);
    Vector answer = name == "forward"
                        ? Vector(pinocchio::aba(model, data, input(q), input(qd), input(third)))
                        : Vector(pinocchio::rnea(model, data, input(q), input(qd), input(third)));
    casadi::SX out(casadi::Sparsity::dense(model.nv, 1));
    for (int i = 0; i < model.nv; ++i)
        out(i) = answer[i];
    // CasADi shares nothing by itself.
    casadi::Function traced("generated", {q, qd, third}, {casadi::SX::cse(std::vector<casadi::SX>{out})[0]});
    for (std::string real : {"double", "float"}) {
        casadi::Dict options{{"casadi_real", real}, {"with_header", false}};
        casadi::CodeGenerator code("casadi_" + name + (real == "float" ? "_f32" : "_f64"), options);
        code.add(traced);
        code.generate(folder + "/");
    }
    std::printf("casadi %s %lld instructions\n", name.c_str(), static_cast<long long>(traced.n_instructions()));
}

int main(int count, char **arguments) {
    if (count != 3)
        return 2;
    Arm arm = read_arm(arguments[1]);
    generate<Angle>(arm, arguments[2], "inverse");
    generate<CosineAndSine>(arm, arguments[2], "kernel");
    generate<Angle>(arm, arguments[2], "forward");
}
