// Whether a gate file is what `fairlead robot compile` made of the robot beside it.
//
// The file's last key, content_sha256, is the digest of every byte before it: a value written in
// by hand no longer fits. `compiled_from` has the digests of robot.yaml, the description and the
// capsules; they are compared where robot.yaml lies beside the gate file. A gate file that is
// deployed alone, to a host without the robot's folder, is judged by its own digest, and by the
// robot hash that the HAL has to tell.
#pragma once

#include <filesystem>
#include <string>

namespace fairlead {

/// Throws ConfigRefused, which names what differs and the command that mends it.
///
/// Returns what the file was compared with, for the log.
std::string check_origin(const std::filesystem::path& file);

/// `fairlead-safety check FILE`: the checks before a start, without one; returns the exit status.
int check_command(const std::string& file);

}  // namespace fairlead
