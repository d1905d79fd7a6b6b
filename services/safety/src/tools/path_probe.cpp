// path-probe: what the gate computes of shapes and motions, for tests to compare with other code.
//
//   path-probe segments
//     stdin: samples of 12 little-endian float64, the ends of two segments; stdout: their distance
//   path-probe boxes
//     stdin: 12, the ends of a segment, a box's lower and upper corner; stdout: the distance
//   path-probe tool CONFIG PART
//     stdin: all measured positions in wire order, then 6, a motion of the part's tool along the
//     root's axes; stdout: 6 for the change of the tool's pose that damped least squares makes of
//     it, 1 if the gate takes it for a solution, else 0, the smallest singular value before, and
//     all positions after
#include <array>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>

#include "config/config_loader.hpp"
#include "core/geometry/distances.hpp"
#include "core/kinematics/inverse_kinematics.hpp"

namespace {

using fairlead::Joints;

bool read_block(double* block, std::size_t count) {
  return std::fread(block, sizeof(double), count, stdin) == count;
}

void write_block(const double* block, std::size_t count) {
  std::fwrite(block, sizeof(double), count, stdout);
}

Eigen::Vector3d point(const double* xyz) { return {xyz[0], xyz[1], xyz[2]}; }

void run_distances(bool boxes) {
  std::array<double, 12> n{};
  while (read_block(n.data(), n.size())) {
    const fairlead::Segment segment{point(&n[0]), point(&n[3])};
    const double distance = boxes
                                ? fairlead::box_distance(segment, {point(&n[6]), point(&n[9])})
                                : fairlead::segment_distance(segment, {point(&n[6]), point(&n[9])});
    write_block(&distance, 1);
  }
}

int run_tool(const fairlead::Limits& limits, std::string_view name) {
  const fairlead::RobotModel model(limits);
  std::size_t part = 0;
  while (part < limits.parts.size() && limits.parts[part].name.view() != name) ++part;
  if (part == limits.parts.size() || !model.tools[part].present) return 2;
  const fairlead::ModelTool& tool = model.tools[part];
  Joints joints{};
  fairlead::Motion6 motion;
  fairlead::FramePoses start, end;
  while (read_block(joints.data(), limits.measured_count()) && read_block(motion.data(), 6)) {
    start.place(model, joints);
    end.place(model, joints);
    const fairlead::ToolJacobian before = fairlead::tool_jacobian(model, tool, start);
    fairlead::Joints first_step;
    const fairlead::Evidence fault =
        fairlead::move_tool(model, tool, motion, start, end, joints, first_step);
    const double solved = fault.ok() ? 1.0 : 0.0;
    const fairlead::ToolJacobian after = fairlead::tool_jacobian(model, tool, end);
    const fairlead::Motion6 made = fairlead::motion_between(before.tool, after.tool);
    const double smallest = fairlead::smallest_singular_value(before);
    write_block(made.data(), 6);
    write_block(&solved, 1);
    write_block(&smallest, 1);
    write_block(joints.data(), limits.measured_count());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view what = argc > 1 ? argv[1] : "";
  try {
    if (argc == 2 && (what == "segments" || what == "boxes")) {
      run_distances(what == "boxes");
      return 0;
    }
    if (argc == 4 && what == "tool") return run_tool(*fairlead::load_limits(argv[2]), argv[3]);
  } catch (const std::exception& refusal) {
    std::fprintf(stderr, "ERROR path-probe: %s\n", refusal.what());
    return 2;
  }
  std::fprintf(stderr, "usage: path-probe segments | boxes | tool CONFIG PART\n");
  return 2;
}
