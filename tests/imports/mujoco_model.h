// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "engine/hand/hand.h"

namespace thenar {

/// A model of MuJoCo's with its data.
struct Mujoco {
  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};

  explicit Mujoco(const std::filesystem::path& file) {
    char error[1000] = "";
    model.reset(mj_loadXML(file.c_str(), nullptr, error, sizeof error));
    if (!model) throw std::runtime_error(error);
    model->opt.disableflags |= mjDSBL_CONTACT;
    data.reset(mj_makeData(model.get()));
  }

  [[nodiscard]] int id(mjtObj kind, const std::string& name) const {
    return mj_name2id(model.get(), kind, name.c_str());
  }

  [[nodiscard]] Eigen::Isometry3d X_WB(const std::string& body) const {
    const int b = id(mjOBJ_BODY, body);
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.translation() = Eigen::Map<Eigen::Vector3d>(data->xpos + 3 * b);
    X.linear() = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * b);
    return X;
  }

  /// Takes the joints' angles over, with those of joints that follow, and finds where all is at rest; joints that the
  /// hand does not have stay as in the file.
  void set(const Hand& hand, const JointVector& q) {
    mju_copy(data->qpos, model->qpos0, model->nq);
    for (int j = 0; j < static_cast<int>(hand.joints.size() + hand.followers.size()); ++j) {
      const bool follows = j >= std::ssize(hand.joints);
      data->qpos[model->jnt_qposadr[joint(hand.joint(j).name)]] =
          follows ? hand.followers[static_cast<std::size_t>(j) - hand.joints.size()].angle(q) : q[j];
    }
    mj_fwdPosition(model.get(), data.get());
    mj_fwdVelocity(model.get(), data.get());
  }

  /// Returns a joint by its name; those without one are called by their body and place, as imports call them.
  [[nodiscard]] int joint(const std::string& name) const {
    if (const int found = id(mjOBJ_JOINT, name); found >= 0) return found;
    for (int j = 0; j < model->njnt; ++j) {
      const int body = model->jnt_bodyid[j];
      const char* const own = mj_id2name(model.get(), mjOBJ_BODY, body);
      const std::string of_body = own != nullptr ? own : unnamed(mjOBJ_BODY, "body" + std::to_string(body));
      if (unnamed(mjOBJ_JOINT, of_body + "_joint" + std::to_string(j - model->body_jntadr[body] + 1)) == name) return j;
    }
    throw std::runtime_error("no joint is called " + name);
  }

  /// Returns a name that nothing else has.
  [[nodiscard]] std::string unnamed(mjtObj kind, std::string name) const {
    while (id(kind, name) >= 0) name += "_2";
    return name;
  }
};

}  // namespace thenar
