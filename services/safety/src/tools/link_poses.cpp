// link-poses: where the gate takes every link of a robot to be, for a test to compare.
//
//   link-poses robots/panda/gate.sim.json
//
// stdin: samples of little-endian float64, all measured positions and then all velocities, in wire
// order. stdout, for each sample and each link in the file's order, the root first: xyz [m],
// quaternion xyzw, linear velocity [m/s], angular velocity [rad/s], in the root's frame.
#include <array>
#include <cstdio>
#include <exception>
#include <memory>

#include "config/config_loader.hpp"
#include "core/kinematics/forward_kinematics.hpp"

namespace {

bool read_block(std::array<double, fairlead::max_measured>& block, std::size_t count) {
  return std::fread(block.data(), sizeof(double), count, stdin) == count;
}

void write(const fairlead::Pose& pose, const fairlead::Twist& twist) {
  const Eigen::Quaterniond q(pose.rotation);
  const std::array<double, 13> row{pose.position.x(),
                                   pose.position.y(),
                                   pose.position.z(),
                                   q.x(),
                                   q.y(),
                                   q.z(),
                                   q.w(),
                                   twist.linear.x(),
                                   twist.linear.y(),
                                   twist.linear.z(),
                                   twist.angular.x(),
                                   twist.angular.y(),
                                   twist.angular.z()};
  std::fwrite(row.data(), sizeof(double), row.size(), stdout);
}

void run(const fairlead::Limits& limits) {
  const auto model = std::make_unique<fairlead::RobotModel>(limits);
  fairlead::MeasuredState state;
  state.count = limits.measured_count();
  while (read_block(state.positions, state.count) && read_block(state.velocities, state.count)) {
    const fairlead::FramePoses poses(*model, state.positions);
    for (std::size_t link = 0; link < limits.kinematics.links.size(); ++link)
      write(fairlead::link_pose(*model, poses, 0, link),
            fairlead::link_twist(*model, state, 0, link));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: link-poses CONFIG\n");
    return 2;
  }
  try {
    run(*fairlead::load_limits(argv[1]));
  } catch (const std::exception& refusal) {
    std::fprintf(stderr, "ERROR link-poses: %s\n", refusal.what());
    return 2;
  }
  return 0;
}
