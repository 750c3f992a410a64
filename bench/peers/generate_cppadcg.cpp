// Pinocchio's algorithms traced by CppAD, written out as C by CppADCodeGen.
//
//     generate_cppadcg ARM FOLDER    writes FOLDER/cppadcg_{inverse,kernel,forward}_{f64,f32}.c
//
// `inverse` and `forward` take angles; `kernel` is the inverse dynamics with cosines and sines for inputs.
#define PINOCCHIO_ARM
#include <pinocchio/codegen/cppadcg.hpp>
#include "arm.hpp"
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

using CG = CppAD::cg::CG<double>;
using AD = CppAD::AD<CG>;
using Vector = Eigen::Matrix<AD, Eigen::Dynamic, 1>;

template <class Axis>
static void generate(const Arm &arm, const std::string &folder, const std::string &name) {
    auto model = pinocchio_arm<Axis>(arm).template cast<AD>();
    typename decltype(model)::Data data(model);
    const int nq = model.nq, nv = model.nv;
    Vector x = Vector::Zero(nq + 2 * nv);
    for (int i = 0; nq > nv && i < nv; ++i)
        x[2 * i] = 1; // a cosine
    CppAD::Independent(x);
    Vector q = x.head(nq), qd = x.segment(nq, nv), third = x.tail(nv);
    Vector y = name == "forward" ? Vector(pinocchio::aba(model, data, q, qd, third))
                                 : Vector(pinocchio::rnea(model, data, q, qd, third));
    CppAD::ADFun<CG> traced(x, y);
    traced.optimize("no_compare_op");

    for (std::string real : {"double", "float"}) {
        CppAD::cg::CodeHandler<double> handler;
        CppAD::vector<CG> inputs(static_cast<size_t>(x.size()));
        handler.makeVariables(inputs);
        CppAD::vector<CG> outputs = traced.Forward(0, inputs);
        CppAD::cg::LanguageC<double> language(real);
        language.setGenerateFunction("generated");
        CppAD::cg::LangCDefaultVariableNameGenerator<double> names;
        std::ofstream file(folder + "/cppadcg_" + name + (real == "float" ? "_f32.c" : "_f64.c"));
        handler.generateCode(file, language, outputs, names);
    }
}

int main(int count, char **arguments) {
    if (count != 3)
        return 2;
    Arm arm = read_arm(arguments[1]);
    generate<Angle>(arm, arguments[2], "inverse");
    generate<CosineAndSine>(arm, arguments[2], "kernel");
    generate<Angle>(arm, arguments[2], "forward");
}
