// SPDX-License-Identifier: Apache-2.0
#include "engine/recordings/state_message.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "engine/models/build_model.h"
#include "engine/recordings/shown_surface.h"
#include "engine/results/recorder.h"
#include "tests/support/scenes.h"

namespace thenar::state_message_test {
namespace {

using nlohmann::ordered_json;

// Fields follow each other without gaps, and the message has all of them and a row a contact.
TEST(StateMessage, HasTheFieldsThatItsSceneTells) {
  for (const char* name : {"box_grasp", "minimal", "stick", "box_wet", "box_stiff", "resting_box"}) {
    SCOPED_TRACE(name);
    Loop loop(scene_of(name));
    loop.run(0.05);
    Picture picture(loop.model);
    take_picture(loop.state, loop.memory, loop.work, picture);
    const TickRecord tick = tick_record(loop.model, loop.state, loop.tick(), loop.report);
    std::string bytes;
    write_state_message(loop.model, picture, tick, loop.controller.f_muscle, {}, bytes);
    const std::vector<Field> fields = state_fields(loop.model);
    std::size_t end = 0;
    for (const Field& field : fields) {
      EXPECT_EQ(field.begin, end) << field.name;
      end += field.count;
    }
    std::size_t row = 0;
    for (const Field& field : contact_fields(loop.model)) row += field.count;
    EXPECT_EQ(read_state_message(bytes).size(), end + row * picture.contacts.size());
    // The same list, in the scene's message.
    const ordered_json scene = scene_message(loop.model, true);
    ASSERT_EQ(scene.at("fields").size(), fields.size());
    EXPECT_EQ(scene.at("fields").back().at("name"), fields.back().name);
  }
}

// Touch and reflex cost no byte where the scene names none.
TEST(StateMessage, SpeaksOfTouchWhereTheSceneDoes) {
  const auto has = [](const std::vector<Field>& fields, const char* name) {
    return std::ranges::find(fields, name, &Field::name) != fields.end();
  };
  for (const auto& [name, feels] : {std::pair{"box_grasp", false}, std::pair{"box_wet", true}}) {
    const Model model = build_model(scene_of(name, {kCoarseBox}));
    for (const char* field : {"stick", "reflex", "last_reflex", "last_reflex_finger", "last_reflex_s"}) {
      EXPECT_EQ(has(state_fields(model), field), feels) << name << ' ' << field;
    }
    EXPECT_EQ(has(contact_fields(model), "slip_m_per_s"), feels) << name;
  }
}

// A rigid fingertip's contact is all of its cell, and its force is split by its normal.
TEST(StateMessage, SpeaksOfSharesWhereFingertipsAreDeformable) {
  for (const bool deformable : {true, false}) {
    Scene scene = scene_of("box_grasp", {kCoarseBox});
    if (!deformable) scene.fingertips.reset();
    const std::vector<Field> fields = contact_fields(build_model(scene));
    for (const char* name : {"normal_N", "friction_N", "share"}) {
      EXPECT_EQ(std::ranges::find(fields, name, &Field::name) != fields.end(), deformable) << name;
    }
  }
}

// Nor does a stiffness, where the scene chooses none: muscles by themselves make no difference.
TEST(StateMessage, SpeaksOfStiffnessWhereTheSceneChoosesOne) {
  Scene chosen = scene_of("box_stiff", {kCoarseBox}), none = chosen, torques = scene_of("box_grasp", {kCoarseBox});
  none.control->muscles->object_stiffness.reset();
  for (const auto& [scene, chooses] : {std::pair{chosen, true}, {none, false}, {torques, false}}) {
    const Model model = build_model(scene);
    const std::vector<Field> fields = state_fields(model);
    for (const char* field : {"asked_N_per_m", "stiffness_share", "stiffness_N_per_m", "lack_s", "least_muscles_N"}) {
      EXPECT_EQ(std::ranges::find(fields, field, &Field::name) != fields.end(), chooses) << field;
    }
    const ordered_json message = scene_message(model, true);
    EXPECT_EQ(message.contains("object_stiffness"), scene.has_muscles() && scene.control->muscles->short_range);
    EXPECT_EQ(chooses, message.value("object_stiffness", ordered_json()).is_object());
  }
}

// Nor do bodies around the object, where there are none.
TEST(StateMessage, SpeaksOfBodiesWhereTheSceneHasSome) {
  const Model none = build_model(scene_of("box_grasp", {kCoarseBox}));
  EXPECT_FALSE(scene_message(none, true).contains("bodies"));
  for (const Field& field : state_fields(none)) {
    EXPECT_FALSE(field.name.starts_with("bodies") || field.name.starts_with("touches")) << field.name;
  }
  Loop loop(scene_of("resting_box"));
  const ordered_json bodies = scene_message(loop.model, true).at("bodies");
  EXPECT_EQ(bodies, ordered_json::parse(R"([{"name": "slope", "shape": "plane", "size_m": [0.0, 0.0, 0.0]}])"));
  loop.run(0.05);
  Picture picture(loop.model);
  take_picture(loop.state, loop.memory, loop.work, picture);
  std::string bytes;
  const TickRecord tick = tick_record(loop.model, loop.state, loop.tick(), loop.report);
  write_state_message(loop.model, picture, tick, loop.controller.f_muscle, {}, bytes);
  const std::vector<double> numbers = read_state_message(bytes);
  const std::vector<Field> fields = state_fields(loop.model);
  const auto at = [&](const char* name) { return std::ranges::find(fields, name, &Field::name)->begin; };
  Eigen::Vector3d sum_N = Eigen::Vector3d::Zero();
  // A box has 8 corners and 12 edges that can touch a plane: all have a place.
  for (std::size_t i = 0; std::isfinite(numbers[at("touches_N") + i]); i += 3) {
    sum_N += Eigen::Map<const Eigen::Vector3d>(&numbers[at("touches_N") + i]);
  }
  EXPECT_GT(sum_N.norm(), 0.1);
  const Eigen::Map<const Eigen::Vector3d> all_N(&numbers[at("bodies_N")]);
  EXPECT_LE((sum_N - all_N).norm(), 1e-12 * sum_N.norm());  // The same numbers, added in another order.
}

// What the geometry holds is what the scene counts: the page has no other way to know.
TEST(StateMessage, CountsTheGeometry) {
  for (const char* name : {"box_grasp", "minimal"}) {
    const Model model = build_model(scene_of(name));
    const ordered_json scene = scene_message(model, true);
    std::size_t floats = 6 * scene.at("object").at("samples").get<std::size_t>();
    for (const ordered_json& finger : scene.at("fingers")) {
      floats += 6 * finger.at("samples").get<std::size_t>() + 4 * finger.at("controls").get<std::size_t>();
    }
    EXPECT_EQ(geometry_message(model).size(), 8 + sizeof(float) * floats) << name;
    // And the surface behind it, where there is one.
    EXPECT_EQ(scene.at("object").at("triangles"), 0);
    const TriangleMesh surface = shown_surface(model);
    ASSERT_GT(surface.triangles.cols(), 0);
    const ordered_json object = scene_message(model, true, surface).at("object");
    EXPECT_EQ(object.at("vertices"), surface.vertices_m.cols());
    EXPECT_EQ(object.at("triangles"), surface.triangles.cols());
    const std::string bytes = geometry_message(model, surface);
    const std::size_t begin = 8 + sizeof(float) * (floats + static_cast<std::size_t>(surface.vertices_m.size()));
    ASSERT_EQ(bytes.size(), begin + sizeof(std::uint32_t) * static_cast<std::size_t>(surface.triangles.size()));
    std::uint32_t last = 0;
    std::memcpy(&last, bytes.data() + bytes.size() - sizeof last, sizeof last);
    EXPECT_EQ(last, static_cast<std::uint32_t>(surface.triangles(2, surface.triangles.cols() - 1)));
  }
}

// A page draws a rigid pulp as what it is.
TEST(StateMessage, NamesTheShapesOfPulpsThatAreNoSpheres) {
  Model model = build_model(scene_of("minimal"));
  PulpShape shape{PulpShape::Form::kCapsule, Eigen::Matrix3d::Identity(), {4e-3, 7e-3, 7e-3}};
  model.scene.hand.fingertips[1].shape = shape;
  const ordered_json fingers = scene_message(model, false).at("fingers");
  EXPECT_FALSE(fingers[0].contains("shape"));
  const ordered_json& told = fingers[1].at("shape");
  EXPECT_EQ(told.at("form"), "capsule");
  EXPECT_EQ(told.at("half_m"), ordered_json({4e-3, 7e-3, 7e-3}));
  EXPECT_EQ(told.at("axes")[2], ordered_json({0.0, 0.0, 1.0}));
}

// Recordings that were made before are read, what is newer than the program is not.
TEST(StateMessage, OfAnotherVersionOrLengthIsNone) {
  std::string bytes = "THNR" + std::string("\x01\x00\x02\x00", 4) + std::string(16, '\0');
  EXPECT_EQ(read_state_message(bytes).size(), 2U);
  EXPECT_TRUE(read_state_message(bytes + "x").empty());
  EXPECT_TRUE(read_state_message(bytes.substr(0, 7)).empty());
  for (const int version : {0, 1, 2, 3, 4}) {
    bytes[4] = static_cast<char>(version);
    EXPECT_EQ(read_state_message(bytes).empty(), version < 1 || version > 3) << version;
  }
}

}  // namespace
}  // namespace thenar::state_message_test
