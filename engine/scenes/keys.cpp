#include "engine/scenes/keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "engine/formats/text.h"

namespace thenar {

namespace {

using enum KeyKind;
using enum Dimension;

// Bounds that are no law of mechanics keep a typo from asking for any amount of memory or time. A step is within the
// rates that loops may have, 100 kHz to 1 Hz. An object's surface takes 430 bytes a point; a pulp's kernel 24 bytes for
// each pair of leaves, 400 MB for 4000; a human fingertip stiffens by about 0.5 1/N.
constexpr std::array kSceneKeys = std::to_array<Key>({
    {"name", kText, kNone, "", "", "The scene's name in results."},

    {"time", kMap, kNone, "", "", "How long the scene runs, and the periods of its two loops."},
    {"time.duration", kQuantity, kTime, "> 0", "", "How long the scene runs: at most 10 million steps."},
    {"time.step",
     kQuantity,
     kTime,
     "10 us .. 1 s",
     "",
     "The period of the contact loop.",
     1,
     {"contact_Hz", "contact rate", "Hz", 200.0, 10'000.0}},
    {"time.control_period",
     kQuantity,
     kTime,
     "> 0",
     "",
     "The period of the control loop: from one time.step to 10000 of them.",
     1,
     {"control_Hz", "control rate", "Hz", 20.0, 2000.0}},
    {"time.control_delay",
     kQuantity,
     kTime,
     ">= 0",
     "0 s",
     "With two loops: the time from a control tick's snapshot to the use of its frame, at most 100 control periods.",
     1,
     {"delay_periods", "delay of frames", "periods", 0.0, 8.0, true}},

    {"gravity", kQuantities, kAcceleration, "", "[0 m/s^2, 0 m/s^2, 0 m/s^2]",
     "The acceleration of gravity in the hand frame, which is the world.", 3},

    {"hand", kMap, kNone, "", "", "The hand, its posture and its joints; or fingertips on slides in place of it."},
    {"hand.model", kPath, kNone, "", "(Required without slides, refused with them.)",
     "The hand file: bones, joints, fingertips and muscles. Beside the scene, or one that comes with the program."},
    {"hand.mirror", kFlag, kNone, "", "(Without it the hand is as its file has it.)",
     "Whether it is the other hand, left for right: the mirror image in the plane z = 0 of the hand frame."},
    {"hand.posture", kQuantities, kAngle, "", "(Required without grasp and slides, refused with one of them.)",
     "The joint angles at the start, in the order of the hand file, each within its joint's limits; none for a joint "
     "that follows another one.",
     kPerJoint},
    {"hand.fingers", kTexts, kNone, "", "(Without it the hand has all of its fingers.)",
     "The fingers that the hand has here, by name; the others are left out, with their joints and muscles."},
    {"hand.settle", kFlag, kNone, "",
     "(Without it the fingers are where the posture has them. A grasp that is found settles.)",
     "Whether the fingers move along the object's normals, before the time begins, until they press with what they are "
     "asked for: a posture by hand need not be right to a tenth of a millimetre."},
    {"hand.joint_viscosity", kQuantity, kRotationalDamping, "> 0", "(Required without slides, refused with them.)",
     "The viscous damping b of every joint."},
    {"hand.torques", kQuantities, kTorque, "",
     "(Required without control, grasp and slides, refused with one of them.)",
     "The constant joint torques of a scene without control.", kPerJoint},
    {"hand.slides", kMaps, kNone, "", "(Without them the scene has a hand.)",
     "One to five fingertips on slides in place of a hand. Each is driven by a force, a spring or a path."},
    {"hand.slides.name", kText, kNone, "", "(Without it: tip1, tip2, and so on.)", "Its name in results."},
    {"hand.slides.at", kQuantities, kLength, "-2 m .. 2 m", "", "The centre of the fingertip at the start.", 3},
    {"hand.slides.along", kQuantities, kNone, "", "",
     "The direction in which it slides and faces, of any length but zero.", 3},
    {"hand.slides.radius", kQuantity, kLength, "0.1 mm .. 100 mm", "", "The radius of the fingertip, a sphere."},
    {"hand.slides.force", kQuantity, kForce, "", "(A slide has a force, a spring or a path.)",
     "The force along the slide that drives it, constant but for its rise."},
    {"hand.slides.rise", kQuantity, kTime, ">= 0", "(Without it the force is there from the start.)",
     "How long its force grows, linearly from zero at the start."},
    {"hand.slides.spring", kMap, kNone, "", "(A slide has a force, a spring or a path.)",
     "A spring along the slide that drives it."},
    {"hand.slides.spring.stiffness", kQuantity, kStiffness, "> 0", "", "Its stiffness."},
    {"hand.slides.spring.rest", kQuantity, kLength, "-1 m .. 1 m", "",
     "How far along the slide from the start the fingertip is where the spring has no force."},
    {"hand.slides.path", kMaps, kNone, "", "(A slide has a force, a spring or a path.)",
     "Where it goes, whatever resists: one leg after the other, each a displacement in any direction. In the end it "
     "stays."},
    {"hand.slides.path.by", kQuantities, kLength, "-1 m .. 1 m", "", "The displacement of this leg, world axes.", 3},
    {"hand.slides.path.over", kQuantity, kTime, "> 0", "", "How long it takes."},
    {"hand.slides.path.profile", kChoice, kNone, "linear | minimum_jerk", "linear",
     "At constant speed, or by minimum jerk from rest to rest."},
    {"hand.slides.damping", kQuantity, kDamping, "> 0", "(Without it 10 N*s/m. Refused with a path.)",
     "The viscous damping of its motion along the slide."},
    {"hand.slides.range", kQuantities, kLength, "-1 m .. 1 m", "(Without it 1 m each way. Refused with a path.)",
     "How far it can slide from where it is at the start: the places of two stops along the slide.", 2},

    {"fingertips", kMap, kNone, "", "(Without them fingers are rigid and touch at one point each.)",
     "Deformable fingertips."},
    {"fingertips.points", kCount, kNone, "1 .. 1000000", "", "The samples of each fingertip's surface."},
    {"fingertips.leaves", kCount, kNone, "1 .. 4000", "",
     "The control points of each fingertip, which its deformation is computed at: at most fingertips.points."},
    {"fingertips.reduced_modulus", kQuantity, kPressure, "> 0", "", "The reduced modulus E* of the pulp."},
    {"fingertips.poisson", kQuantity, kNone, "0 .. 0.5", "", "Poisson's ratio of the pulp."},
    {"fingertips.relaxation", kQuantity, kTime, ">= 0", "",
     "The retardation time of the pulp, in which it loses all but 1/e of its deformation without load; 0 is elastic."},
    {"fingertips.kernel",
     kChoice,
     kNone,
     "boussinesq | gaussian",
     "boussinesq",
     "How a force deforms the pulp around it: as in an elastic half space, or by the published influence function, "
     "which holds at one depth.",
     1,
     {"kernel", "kernel", ""}},
    {"fingertips.stiffening", kQuantity, kPerForce, "0 .. 10 1/N", "(Without it the modulus is constant.)",
     "The share by which the modulus grows for each newton of normal load on a fingertip."},
    {"fingertips.touch", kMap, kNone, "", "(Without it fingertips feel nothing but their loads.)",
     "What fingertips feel of their patches: how much of them sticks, and where the rim slips, the friction."},
    {"fingertips.touch.delay", kQuantity, kTime, "0 s .. 1 s", "65 ms",
     "From what happens at the skin to the command that answers it: people take 60 to 90 ms."},
    {"fingertips.touch.noise", kQuantity, kShare, "0 % .. 100 %", "0 %",
     "Standard deviation of what is felt of each contact's normal and tangential force."},
    {"fingertips.touch.seed", kCount, kNone, "0 .. 1000000", "1", "The seed of the noise."},

    {"object", kMap, kNone, "", "", "The object that is held."},
    {"object.shape", kOneOf, kNone, "", "", "The object's shape, with full sizes; an axis of revolution is z."},
    {"object.shape.box", kQuantities, kLength, "0.1 mm .. 10 m", "", "The sizes of a box along x, y and z.", 3},
    {"object.shape.sphere", kQuantity, kLength, "0.1 mm .. 10 m", "", "The radius of a sphere."},
    {"object.shape.ellipsoid", kQuantities, kLength, "0.1 mm .. 10 m", "",
     "The sizes of an ellipsoid along x, y and z.", 3},
    {"object.shape.cylinder", kMap, kNone, "", "", "A cylinder."},
    {"object.shape.cylinder.radius", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its radius."},
    {"object.shape.cylinder.length", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its length along z."},
    {"object.shape.superquadric", kMap, kNone, "", "", "A superquadric."},
    {"object.shape.superquadric.size", kQuantities, kLength, "0.1 mm .. 10 m", "", "Its sizes along x, y and z.", 3},
    {"object.shape.superquadric.exponents", kQuantities, kNone, "0.1 .. 2", "",
     "Its exponents in sections along z and across it: 0.1 is nearly a box's, 1 an ellipsoid's, 2 an octahedron's.", 2},
    {"object.shape.mug", kMap, kNone, "", "", "A mug, open at the top of z."},
    {"object.shape.mug.radius", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its outer radius."},
    {"object.shape.mug.height", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its height along z."},
    {"object.shape.mug.wall", kQuantity, kLength, "0.1 mm .. 10 m", "",
     "The thickness of its wall and bottom, less than radius and height."},
    {"object.shape.mug.handle", kMap, kNone, "", "(Without it the mug has no handle.)",
     "Its handle, on the side of x."},
    {"object.shape.mug.handle.radius", kQuantity, kLength, "0.1 mm .. 10 m", "",
     "The radius of the handle's middle line."},
    {"object.shape.mug.handle.thickness", kQuantity, kLength, "0.1 mm .. 10 m", "",
     "The diameter of the handle itself, less than twice its radius."},
    {"object.shape.cloud", kPath, kNone, "", "", "A mesh or a point cloud in metres; as a map, a file in any unit."},
    {"object.shape.cloud.file", kPath, kNone, "", "", "The file of the mesh or the point cloud."},
    {"object.shape.cloud.unit", kQuantity, kLength, "> 0 | m | cm | mm | um", "1 m",
     "What 1 in the file measures: a unit or a length."},
    {"object.points", kCount, kNone, "10 .. 1000000",
     "(Required, but refused with a point cloud, which brings its own.)", "The samples of the object's surface."},
    {"object.mass", kQuantity, kMass, "> 0", "", "The object's mass."},
    {"object.centre_of_mass", kQuantities, kLength, "",
     "(Without it: the centroid of a generated solid, the origin of one from a file.)",
     "Where the weight acts, in the object frame, inside the object.", 3},
    {"object.position", kQuantities, kLength, "", "(Required without grasp, refused with it.)",
     "The origin of the object frame at the start, in the hand frame.", 3},
    {"object.rotation", kRotation, kNone, "", "(Required without grasp, refused with it.)",
     "The rotation of the object at the start: its columns are the object's axes in the hand frame."},
    {"object.damping", kMap, kNone, "", "", "The viscous damping of the object's motion."},
    {"object.damping.translation", kQuantity, kDamping, "> 0", "", "The damping of its translation."},
    {"object.damping.rotation", kQuantity, kRotationalDamping, "> 0", "", "The damping of its rotation."},
    {"object.compliance", kMap, kNone, "", "(Without it the object is rigid.)",
     "How the object's surface gives way; it needs deformable fingertips."},
    {"object.compliance.reduced_modulus", kQuantity, kPressure, ">= 1 kPa", "", "Its reduced modulus E*."},
    {"object.compliance.poisson", kQuantity, kNone, "0 .. 0.5", "", "Its Poisson's ratio."},
    {"object.compliance.relaxation", kQuantity, kTime, ">= 0", "", "Its retardation time, as that of fingertips."},

    {"grasp", kMap, kNone, " | auto", "(Without it hand and object begin where the scene places them.)",
     "A grasp that is found: which fingers hold the object where, with what posture, and how the object lies in the "
     "hand. What is not named here is chosen."},
    {"grasp.fingers", kTexts, kNone, "", "(Without it all of them, or as many as find a place.)",
     "The fingers that are to hold, by name; the others are left out of the scene."},
    {"grasp.axis", kQuantities, kNone, "", "(Without it any.)",
     "The line on which the fingers face each other, in the object's axes, of any length but zero.", 3},
    {"grasp.at", kQuantities, kLength, "", "(Without it anywhere.)",
     "Near which point of the object frame, half-way between the fingers, it is held.", 3},
    {"grasp.approach", kQuantities, kNone, "", "(Without it any.)",
     "The way in which the hand comes to the object, in the object's axes, of any length but zero.", 3},
    {"grasp.press", kQuantity, kForce, "> 0", "(Required without control; else control.grasp.internal_force.)",
     "The normal load of the least loaded finger, under the weight at rest."},
    {"grasp.rank", kCount, kNone, "1 .. 20", "1", "Which of the grasps that are found: 1 is the best."},
    {"grasp.seed", kCount, kNone, "0 .. 1000000", "1", "The seed of the search: the same one finds the same grasp."},

    {"contact", kMap, kNone, "", "", "Contacts between fingers and object."},
    {"contact.friction",
     kQuantity,
     kNone,
     "0 .. 10",
     "",
     "Coulomb's coefficient of friction.",
     1,
     {"friction", "friction", "", 0.0, 2.0}},
    {"contact.band", kQuantity, kLength, "> 0", "", "Control points with a gap below this are candidates for contact."},
    {"contact.distance_error", kQuantity, kLength, "0 .. 0.1 mm", "1 um",
     "How far, for speed, the distances of deformable fingertips' points may be off those of the surface that the "
     "samples stand for: 0 takes the surface itself."},
    {"contact.max_per_finger", kCount, kNone, "1 .. 1000", "(Required with deformable fingertips, refused without.)",
     "The most contacts of a finger: those of the smallest gaps are kept."},
    {"contact.level",
     kChoice,
     kNone,
     "leaves | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | auto",
     "leaves",
     "The level of detail of deformable fingertips: all leaves; a control point for about 2, 4, 8 and so on of them; "
     "auto: the coarsest level within contact.force_error.",
     1,
     {"level", "level of the pulps", "", 0.0, 6.0, true}},
    {"contact.force_error", kQuantity, kShare, ">= 0", "5 %",
     "With contact.level auto: how far a fingertip's force may be off Hertz's, rms."},
    {"contact.tolerance",
     kQuantity,
     kNone,
     "1e-14 .. 1",
     "1e-7",
     "The natural-map residual at which a contact tick stops its sweeps.",
     1,
     {"tolerance", "solver tolerance", "", 1e-10, 0.1}},
    {"contact.max_sweeps",
     kCount,
     kNone,
     "1 .. 1000000",
     "200",
     "The most sweeps of a contact tick.",
     1,
     {"max_sweeps", "solver sweeps, at most", "", 1.0, 1000.0, true}},

    {"control", kMap, kNone, "", "(Without it hand.torques drive the joints, or hand.slides the fingertips.)",
     "The controller of the object's position and the grip."},
    {"control.law", kChoice, kNone, "feedforward | paper", "",
     "The law of joint torques: with the desired forces fed forward, or as published, which leaves a steady force "
     "error."},
    {"control.gain", kQuantity, kRotationalStiffness, "> 0 | auto", "",
     "The gain K of eq. (22); auto takes it from joint viscosity, control period and delay."},
    {"control.pulp", kMap, kNone, "", "", "The controller's model of a pulp."},
    {"control.pulp.normal", kQuantity, kStiffness, "> 0", "", "Its normal stiffness."},
    {"control.pulp.tangential", kQuantity, kStiffness, "> 0", "", "Its tangential stiffness."},
    {"control.grasp", kMap, kNone, "", "", "The grasp forces that the controller asks for."},
    {"control.grasp.friction", kQuantity, kNone, "0 .. 10 | felt", "",
     "The coefficient of friction of their cones; felt: of each finger, what its fingertip feels, with "
     "control.grasp.margin."},
    {"control.grasp.margin", kQuantity, kNone, "0 .. 10", "(Required with felt friction, refused without.)",
     "By how much more the fingers press than the felt friction needs, as a share: 0.3 is what people leave."},
    {"control.grasp.first_friction", kQuantity, kNone, "0.01 .. 10", "(Required with felt friction, refused without.)",
     "The friction that is expected of a finger until it has felt some."},
    {"control.grasp.internal_force",
     kQuantity,
     kForce,
     ">= 0",
     "(Required without grasp.press, refused with it.)",
     "The internal force, by which the fingers squeeze.",
     1,
     {"internal_force_N", "squeeze", "N", 0.1, 20.0}},
    {"control.grasp.cone", kChoice, kNone, "pyramid | exact", "exact", "The shape of their friction cones."},
    {"control.position", kMap, kNone, "", "", "The PID controller of the object's position."},
    {"control.position.p", kQuantity, kStiffness, ">= 0", "", "Its proportional gain."},
    {"control.position.i", kQuantity, kIntegralGain, ">= 0", "0 N/(m*s)", "Its integral gain."},
    {"control.position.d", kQuantity, kDamping, ">= 0", "0 N*s/m", "Its derivative gain."},
    {"control.rotation", kMap, kNone, "", "", "The PID controller of the object's rotation."},
    {"control.rotation.p", kQuantity, kRotationalStiffness, ">= 0", "", "Its proportional gain."},
    {"control.rotation.i", kQuantity, kRotationalIntegralGain, ">= 0", "0 N*m/(rad*s)", "Its integral gain."},
    {"control.rotation.d", kQuantity, kRotationalDamping, ">= 0", "0 N*m*s", "Its derivative gain."},
    {"control.centre", kQuantities, kLength, "", "(Without it: the object's origin.)",
     "The point of the object that control.position keeps at its place, object frame: where forces do not turn it, and "
     "moments do not shift it. At the tip of a peg, walls correct its place and its tilt one by one.",
     3},
    {"control.posture", kQuantity, kRotationalStiffness, "> 0", "(Without it the posture drifts there.)",
     "A spring to the posture of the start, where the fingertips leave the joints free."},
    {"control.feedback_delay", kQuantity, kTime, "0 s .. 1 s", "(Without it what is known is of now.)",
     "How old all that the controller knows is: of the object's pose, the joints and the fingers' loads."},
    {"control.anticipation", kFlag, kNone, "", "(Without it nothing is anticipated.)",
     "Whether what the motion that is planned will need is fed forward: against the viscosity of object and joints, "
     "and "
     "for the load that the arm makes."},
    {"control.reflex", kMap, kNone, "", "(Without it the grip does not answer to what is felt.)",
     "How the grip answers to what fingertips feel. It needs fingertips.touch."},
    {"control.reflex.load_rate", kQuantity, kForceRate, "> 0", "2 N/s",
     "A finger whose tangential load changes faster than expected gets a pulse of grip."},
    {"control.reflex.pulse", kQuantity, kTime, "1 ms .. 2 s", "220 ms", "How long the grip rises in a pulse."},
    {"control.reflex.release", kQuantity, kTime, "10 ms .. 10 s", "0.5 s",
     "The time constant with which the grip goes back after a pulse."},
    {"control.reflex.stick", kQuantity, kNone, "0 .. 0.95", "0.35",
     "The least share of a patch that is to stick: with less of it, the squeeze rises."},
    {"control.reflex.regulation", kQuantity, kRate, ">= 0", "5 1/s",
     "How fast it rises and falls again. Much above 1/(2 x the touch's delay) it swings."},
    {"control.muscles", kMap, kNone, " | true | false", "",
     "Whether muscles drive the joints, or torques as they are; as a map, what muscles are beyond their forces."},
    {"control.muscles.activation", kQuantity, kTime, "1 ms .. 1 s", "(Without it forces are there at once.)",
     "The time constant with which forces rise to what is asked for, at an activation of a third."},
    {"control.muscles.deactivation", kQuantity, kTime, "1 ms .. 1 s", "40 ms", "Likewise, with which they fall."},
    {"control.muscles.stiffness", kQuantity, kNone, "0.1 .. 100", "(Without it lengths change no force.)",
     "gamma of the stiffness k = gamma f / L of fibres of length L under a force f: 23.4 in Cui et al. 2008."},
    {"control.muscles.object_stiffness", kMap, kNone, "", "(Without it the least muscle forces do.)",
     "How stiff the hand is to hold the object at least: muscle forces are chosen for it. It needs stiffness."},
    {"control.muscles.object_stiffness.translation",
     kQuantities,
     kStiffness,
     ">= 0",
     "",
     "Along the object's axes.",
     3,
     {"asked_N_per_m", "stiffness along x, y, z", "N/m", 0.0, 1000.0}},
    {"control.muscles.object_stiffness.rotation",
     kQuantities,
     kRotationalStiffness,
     ">= 0",
     "",
     "About them.",
     3,
     {"asked_Nm_per_rad", "stiffness about x, y, z", "N m/rad", 0.0, 0.5}},
    {"control.muscles.object_stiffness.centre", kQuantities, kLength, "", "(Without it: its origin.)",
     "The point about which these are meant, object frame.", 3},
    {"control.muscles.object_stiffness.squeeze", kQuantity, kForce, "> 0", "(Without it the squeeze stays.)",
     "How far the internal force may rise above control.grasp.internal_force for it."},
    {"control.muscles.frozen_from", kQuantity, kTime, ">= 0", "(Without it they follow the law at all times.)",
     "From this time on excitations stay as they are: forces change with lengths alone."},
    {"control.drive", kPath, kNone, "", "(Without it the law drives them.)",
     "A table of joint torques or muscle forces by time that drive the joints instead: a CSV file with time_s and a "
     "column "
     "JOINT_Nm for each joint, or MUSCLE_N for each muscle, as signals.csv has them."},

    {"environment", kMap, kNone, "", "(Without it the object touches the fingers alone.)",
     "What is around the object: rigid bodies with exact surfaces. Fingers do not touch them."},
    {"environment.friction",
     kQuantity,
     kNone,
     "0 .. 10",
     "(Required where a body has none of its own.)",
     "Coulomb's coefficient of friction between object and bodies.",
     1,
     {"around_friction", "friction of bodies", "", 0.0, 2.0}},
    {"environment.compliance",
     kQuantity,
     kCompliance,
     "1e-10 m/N .. 1e-3 m/N",
     "100 nm/N",
     "How far object and body give way at each contact, by a newton in any direction.",
     1,
     {"around_m_per_N", "compliance", "m/N", 1e-9, 1e-5}},
    {"environment.bodies", kMaps, kNone, "", "", "The bodies."},
    {"environment.bodies.name", kText, kNone, "", "(Without it: its number.)",
     "What it is called where it is told of."},
    {"environment.bodies.shape", kOneOf, kNone, "", "", "Its shape, with full sizes; an axis of revolution is z."},
    {"environment.bodies.shape.plane", kFlag, kNone, "", "", "true: all that is below z = 0."},
    {"environment.bodies.shape.box", kQuantities, kLength, "0.1 mm .. 10 m", "", "The sizes of a box along x, y and z.",
     3},
    {"environment.bodies.shape.sphere", kQuantity, kLength, "0.1 mm .. 10 m", "", "The radius of a sphere."},
    {"environment.bodies.shape.cylinder", kMap, kNone, "", "", "A cylinder."},
    {"environment.bodies.shape.cylinder.radius", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its radius."},
    {"environment.bodies.shape.cylinder.length", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its length along z."},
    {"environment.bodies.shape.hole", kMap, kNone, "", "", "All that is below z = 0, with a blind hole down along z."},
    {"environment.bodies.shape.hole.diameter", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its diameter."},
    {"environment.bodies.shape.hole.depth", kQuantity, kLength, "0.1 mm .. 10 m", "", "Its depth."},
    {"environment.bodies.shape.hole.chamfer", kQuantity, kLength, "0 .. 10 m", "0 mm",
     "The width of the chamfer at its mouth, of 45 degrees."},
    {"environment.bodies.position", kQuantities, kLength, "", "", "Of its frame, in the hand's, which is the world.",
     3},
    {"environment.bodies.rotation", kRotation, kNone, "", "(Without it: as the world is.)",
     "Of its frame: its columns are the body's axes in the world."},
    {"environment.bodies.friction", kQuantity, kNone, "0 .. 10", "(Without it: environment.friction.)",
     "Its own coefficient of friction against the object."},
    {"environment.bodies.move", kMaps, kNone, "", "(Without it the body stays where it is.)",
     "Minimum-jerk moves, which add up. A table that moves down is an arm that lifts."},
    {"environment.bodies.move.by", kQuantities, kLength, "", "", "How far, world axes.", 3},
    {"environment.bodies.move.from", kQuantity, kTime, ">= 0", "", "When it begins."},
    {"environment.bodies.move.over", kQuantity, kTime, "> 0", "", "How long it takes."},

    {"task", kMap, kNone, "", "(Without it the target stays where the object starts.)",
     "What becomes of the object's target, and what acts on the object."},
    {"task.translate", kMap, kNone, "", "(Without it the target does not move.)", "A minimum-jerk move of the target."},
    {"task.translate.by", kQuantities, kLength, "", "", "How far, along the object's axes at the start.", 3},
    {"task.translate.from", kQuantity, kTime, ">= 0", "", "When it begins."},
    {"task.translate.over", kQuantity, kTime, "> 0", "", "How long it takes."},
    {"task.rotate", kMap, kNone, "", "(Without it the target does not turn.)", "A minimum-jerk turn of the target."},
    {"task.rotate.by", kQuantity, kAngle, "", "", "How far."},
    {"task.rotate.about", kQuantities, kNone, "", "",
     "The axis in the object's axes at the start, of any length but zero.", 3},
    {"task.rotate.from", kQuantity, kTime, ">= 0", "", "When it begins."},
    {"task.rotate.over", kQuantity, kTime, "> 0", "", "How long it takes."},
    {"task.spring", kMap, kNone, "", "(Without it no spring acts.)", "A spring that ties the object to its target."},
    {"task.spring.translation", kQuantity, kStiffness, "> 0", "", "Its stiffness in translation."},
    {"task.spring.rotation", kQuantity, kRotationalStiffness, "> 0", "", "Its stiffness in rotation."},
    {"task.push", kMap, kNone, "", "(Without it nothing pushes.)",
     "A constant force and moment on the object, in its axes at the start, which the controller does not know of."},
    {"task.push.force", kQuantities, kForce, "", "(Required without task.push.moment.)", "The force.", 3},
    {"task.push.at", kQuantities, kLength, "", "(Without it: its origin.)",
     "Where the force acts, in the object frame, inside the object.", 3},
    {"task.push.moment", kQuantities, kTorque, "", "(Without it no moment acts.)",
     "The moment, with the force or alone.", 3},
    {"task.push.from", kQuantity, kTime, ">= 0", "", "When it begins."},
    {"task.push.over", kQuantity, kTime, "> 0", "", "How long it lasts."},
    {"task.push.rise", kQuantity, kTime, ">= 0", "(Without it all of it acts at once.)",
     "How long it takes to grow from nothing, linearly."},
    {"task.arm", kMap, kNone, "", "(Without it the hand does not accelerate.)",
     "The arm that carries the hand swings along a line: the hand is the world, and the load of it acts on object and "
     "bones as a gravity that changes."},
    {"task.arm.along", kQuantities, kNone, "", "",
     "The line, in the object's axes at the start, of any length but zero.", 3},
    {"task.arm.amplitude", kQuantity, kLength, "> 0", "", "How far it swings to either side."},
    {"task.arm.frequency", kQuantity, kFrequency, "0.01 Hz .. 100 Hz", "", "Swings a second."},
    {"task.arm.from", kQuantity, kTime, ">= 0", "",
     "When it begins: over the first swing, and from the last, it swings "
     "less."},
    {"task.arm.over", kQuantity, kTime, "> 0", "", "How long it lasts."},
    {"task.friction", kMaps, kNone, "", "(Without it friction stays what it is.)",
     "Steps of contact.friction, in the order of time: an object that becomes wet."},
    {"task.friction.at", kQuantity, kTime, ">= 0", "", "When it changes."},
    {"task.friction.to", kQuantity, kNone, "0 .. 10", "", "The coefficient from then on."},
    {"task.phases", kMaps, kNone, "", "(Without it a task goes by times alone.)",
     "The phases of a task in an environment, one after the other. Each ends when what it is for has come about, and "
     "fails if that takes too long. Where the arm goes, what is around the object goes the other way."},
    {"task.phases.approach", kMap, kNone, "", "(Each phase is one of these.)",
     "The arm goes, the fingers still and clear of the object."},
    {"task.phases.approach.by", kQuantities, kLength, "", "",
     "How far the arm goes, along the object's axes at the start.", 3},
    {"task.phases.approach.over", kQuantity, kTime, "> 0", "", "How long that takes, by minimum jerk."},
    {"task.phases.approach.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.phases.close", kMap, kNone, "", "(Each phase is one of these.)",
     "The fingers go towards the object until all of them press it."},
    {"task.phases.close.press", kQuantity, kForce, "> 0", "", "The internal force then."},
    {"task.phases.close.speed", kQuantity, kSpeed, "> 0", "",
     "How fast a finger goes along the object's nearest normal."},
    {"task.phases.close.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.phases.load", kMap, kNone, "", "(Each phase is one of these.)",
     "The fingers take over the object's weight, and their squeeze rises with it to control.grasp.internal_force."},
    {"task.phases.load.over", kQuantity, kTime, "> 0", "", "How long they rise."},
    {"task.phases.load.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.phases.lift", kMap, kNone, "", "(Each phase is one of these.)",
     "The arm goes; in the end the fingers bear the weight, no less and no more."},
    {"task.phases.lift.by", kQuantities, kLength, "", "", "How far the arm goes, along the object's axes at the start.",
     3},
    {"task.phases.lift.over", kQuantity, kTime, "> 0", "", "How long that takes, by minimum jerk."},
    {"task.phases.lift.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.phases.move", kMap, kNone, "", "(Each phase is one of these.)", "The same, in any direction."},
    {"task.phases.move.by", kQuantities, kLength, "", "", "How far the arm goes, along the object's axes at the start.",
     3},
    {"task.phases.move.over", kQuantity, kTime, "> 0", "", "How long that takes, by minimum jerk."},
    {"task.phases.move.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.phases.insert", kMap, kNone, "", "(Each phase is one of these.)", "The arm goes against what resists."},
    {"task.phases.insert.by", kQuantities, kLength, "", "",
     "How far the arm goes, along the object's axes at the start.", 3},
    {"task.phases.insert.over", kQuantity, kTime, "> 0", "", "How long that takes, by minimum jerk."},
    {"task.phases.insert.most_force", kQuantity, kForce, "> 0", "", "What resists by more has jammed."},
    {"task.phases.insert.position", kMap, kNone, "", "(Without it: control.position.)",
     "The PID controller of the object's position in this phase. Without an integral gain it does not push on against "
     "a wall."},
    {"task.phases.insert.position.p", kQuantity, kStiffness, ">= 0", "", "Its proportional gain."},
    {"task.phases.insert.position.i", kQuantity, kIntegralGain, ">= 0", "0 N/(m*s)", "Its integral gain."},
    {"task.phases.insert.position.d", kQuantity, kDamping, ">= 0", "0 N*s/m", "Its derivative gain."},
    {"task.phases.insert.rotation", kMap, kNone, "", "(Without it: control.rotation.)", "That of its rotation."},
    {"task.phases.insert.rotation.p", kQuantity, kRotationalStiffness, ">= 0", "", "Its proportional gain."},
    {"task.phases.insert.rotation.i", kQuantity, kRotationalIntegralGain, ">= 0", "0 N*m/(rad*s)",
     "Its integral gain."},
    {"task.phases.insert.rotation.d", kQuantity, kRotationalDamping, ">= 0", "0 N*m*s", "Its derivative gain."},
    {"task.phases.insert.centre", kQuantities, kLength, "", "(Without it: control.centre.)",
     "The point that position keeps at its place, object frame.", 3},
    {"task.phases.insert.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.phases.place", kMap, kNone, "", "(Each phase is one of these.)",
     "The arm goes until something bears half of the weight, stops, and the fingers leave it the rest."},
    {"task.phases.place.by", kQuantities, kLength, "", "",
     "How far the arm goes at the most, along the object's axes at the start.", 3},
    {"task.phases.place.over", kQuantity, kTime, "> 0", "", "How long that takes, by minimum jerk."},
    {"task.phases.place.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.phases.release", kMap, kNone, "", "(Each phase is one of these.)", "The fingers let go, and open."},
    {"task.phases.release.open", kQuantity, kLength, "> 0", "", "How far, along the object's normals."},
    {"task.phases.release.speed", kQuantity, kSpeed, "> 0", "", "How fast."},
    {"task.phases.release.within", kQuantity, kTime, "> 0", "(Without it: 10 s more than it takes.)",
     "What has not come about by then has failed."},
    {"task.lost", kQuantity, kLength, "> 0", "(Without it: by the radius of its pulp.)",
     "A finger that slid so far has lost the object."},

    {"model", kChoice, kNone, "full | auto", "full",
     "What is modelled: all that the scene names, or only the parts that its tolerance needs."},
    {"tolerance", kMap, kNone, "", "(Without it its keys have their defaults.)",
     "How far the object's path and the fingers' forces may be off the full model's."},
    {"tolerance.position", kQuantity, kLength, ">= 0", "0.1 mm", "Of the object's position, rms and at the end."},
    {"tolerance.rotation", kQuantity, kAngle, ">= 0", "0.1 deg", "Of the object's rotation, rms and at the end."},
    {"tolerance.force", kQuantity, kShare, ">= 0", "5 %", "Of the fingers' forces, rms."},
    {"tolerance.moment", kQuantity, kShare, ">= 0", "10 %",
     "Of the fingers' torsions, rms, as a share of the most that friction allows."},
    {"tolerance.margin", kQuantity, kNone, "0 .. 1", "0.05", "Of the fingers' margins, rms."},
});

// In SI units without their names; lengths of vectors that are directions do not count.
constexpr std::array kHandKeys = std::to_array<Key>({
    {"joints", kMaps, kNone, "", "", "The joints, finger by finger, each from the palm on: up to five a finger."},
    {"joints.name", kText, kNone, "", "", "Its name."},
    {"joints.origin_at_q0", kQuantities, kNone, "-2 .. 2", "", "A point of its axis at q = 0, hand frame, in m.", 3},
    {"joints.axis_at_q0", kQuantities, kNone, "", "", "The direction of its axis at q = 0, hand frame.", 3},
    {"joints.limits", kQuantities, kNone, "-6.3 .. 6.3", "", "The ends of its range, in rad: a turn each way at most.",
     2},
    {"joints.follows", kText, kNone, "", "(It turns by itself.)",
     "The joint of its finger, nearer to the palm, that it turns with: it has no angle of its own."},
    {"joints.ratio", kQuantity, kNone, "-100 .. 100", "1", "Its angle over that of the joint that it follows."},
    {"joints.offset", kQuantity, kNone, "-100 .. 100", "0", "What is added to that, in rad."},

    {"segments", kMaps, kNone, "", "", "The bones but for the palm."},
    {"segments.name", kText, kNone, "", "", "Its name."},
    {"segments.moved_by", kTexts, kNone, "", "", "The first joints of one finger, in their order."},
    {"segments.length", kQuantity, kNone, "0 .. 1", "", "Its length in m."},
    {"segments.mass", kQuantity, kNone, "0 .. 10", "", "Its mass in kg."},
    {"segments.com", kQuantities, kNone, "", "", "Its centre of mass, in its frame, in m.", 3},
    {"segments.frame_at_q0", kMap, kNone, "", "", "Its frame at q = 0."},
    {"segments.frame_at_q0.R", kRotation, kNone, "", "", "Its rotation."},
    {"segments.frame_at_q0.origin", kQuantities, kNone, "", "", "Its origin in m.", 3},

    {"fingertips", kMaps, kNone, "", "", "The fingertips, one a finger, in the order of the joints: up to five."},
    {"fingertips.finger", kText, kNone, "", "", "Its finger's name."},
    {"fingertips.segment", kText, kNone, "", "",
     "The last segment of its finger: its `moved_by` are the finger's joints."},
    {"fingertips.pulp_centre", kQuantities, kNone, "-2 .. 2", "", "The centre of its pulp, segment frame, in m.", 3},
    {"fingertips.radius", kQuantity, kNone, "1e-4 .. 0.1", "(Required without semi_axes.)",
     "The radius of its pulp in m: a sphere, or with a length a capsule."},
    {"fingertips.length", kQuantity, kNone, "1e-4 .. 0.2", "(Without it the pulp is no capsule.)",
     "Of a capsule: from the centre of one round end to that of the other, in m. Half of it is on either side of "
     "pulp_centre."},
    {"fingertips.semi_axes", kQuantities, kNone, "1e-4 .. 0.1", "(Without them the pulp is no ellipsoid.)",
     "Of an ellipsoid, in m: along the pulp, across it, and through it; the largest at most 4 times the least.", 3},
    {"fingertips.pulp_axes", kRotation, kNone, "",
     "(Of a capsule: its first axis is the segment's x. Of an ellipsoid: its third axis is pulp_normal, its first one "
     "x "
     "less what of it is along that.)",
     "How these axes lie in the segment frame: its columns. A capsule lies along the first."},
    {"fingertips.pulp_normal", kQuantities, kNone, "", "", "The mean outward direction of its pulp, segment frame.", 3},
    {"fingertips.joint_viscosity", kQuantity, kNone, "> 0", "(The scene's.)",
     "The viscous damping of its joints in N m s."},
    {"fingertips.reduced_modulus", kQuantity, kNone, "> 0", "(The scene's.)", "The modulus E* of its pulp in Pa."},
    {"fingertips.poisson", kQuantity, kNone, "0 .. 0.5", "(The scene's.)", "Poisson's ratio of its pulp."},
    {"fingertips.relaxation", kQuantity, kNone, ">= 0", "(The scene's.)", "The retardation time of its pulp in s."},

    {"muscles", kMaps, kNone, "", "(Without them torques drive the joints.)", "The muscles."},
    {"muscles.name", kText, kNone, "", "", "Its name."},
    {"muscles.max_force", kQuantity, kNone, "0 .. 1e4", "", "The most force that it has, in N."},
    {"muscles.fibre_length", kQuantity, kNone, "1e-3 .. 1", "(None: it has no stiffness.)",
     "The length of its fibres at rest, in m."},
    {"muscles.tendon_stiffness", kQuantity, kNone, "> 0", "(Its tendon is rigid.)",
     "The stiffness of its tendon, in N/m."},
    {"muscles.crossings", kMaps, kNone, "", "", "Where its tendon crosses joints."},
    {"muscles.crossings.joints", kTexts, kNone, "", "", "The joints that it crosses."},
    {"muscles.crossings.share", kQuantity, kNone, "0 .. 1", "1", "The share of the muscle's force."},
    {"muscles.crossings.insertion", kMap, kNone, "", "", "Where it pulls, distal to the joints."},
    {"muscles.crossings.insertion.segment", kText, kNone, "", "", "The segment."},
    {"muscles.crossings.insertion.pos", kQuantities, kNone, "", "", "The point, segment frame, in m.", 3},
    {"muscles.crossings.pull", kOneOf, kNone, "", "", "Where it pulls to."},
    {"muscles.crossings.pull.via", kMap, kNone, "", "", "A point."},
    {"muscles.crossings.pull.via.segment", kText, kNone, "", "", "Its segment."},
    {"muscles.crossings.pull.via.pos", kQuantities, kNone, "", "", "Its place, segment frame, in m.", 3},
    {"muscles.crossings.pull.dir", kMap, kNone, "", "", "A direction."},
    {"muscles.crossings.pull.dir.segment", kText, kNone, "", "", "The segment that it turns with."},
    {"muscles.crossings.pull.dir.vec", kQuantities, kNone, "", "", "Its vector, segment frame.", 3},
});

/// The parts between separators.
std::vector<std::string_view> split(std::string_view text, std::string_view separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == text.npos) return parts;
    text.remove_prefix(end + separator.size());
  }
}

double bound(const Key& key, std::string_view text) {
  const bool is_zero = text == "0";  // of any unit
  const Quantity quantity = is_zero ? Quantity{} : read_quantity(text, key.dimension);
  if (!quantity.fault.empty()) throw std::logic_error(fmt::format("range of {}: {}", key.path, quantity.fault));
  return quantity.value;
}

}  // namespace

Keys scene_keys() { return kSceneKeys; }
Keys hand_keys() { return kHandKeys; }

const Key* find_key(Keys keys, std::string_view path) {
  const auto found = std::ranges::find(keys, path, &Key::path);
  return found == keys.end() ? nullptr : &*found;
}

const Key* find_live_key(Keys keys, std::string_view name) {
  const auto found = std::ranges::find_if(keys, [&](const Key& key) { return !name.empty() && key.live.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

std::string_view parent_of(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  return dot == path.npos ? "" : path.substr(0, dot);
}

std::string_view name_of(const Key& key) { return key.path.substr(key.path.rfind('.') + 1); }

std::vector<const Key*> keys_below(Keys keys, std::string_view path) {
  std::vector<const Key*> below;
  for (const Key& key : keys) {
    if (parent_of(key.path) == path) below.push_back(&key);
  }
  return below;
}

std::vector<std::string_view> names_below(Keys keys, std::string_view path) {
  std::vector<std::string_view> names;
  for (const Key* key : keys_below(keys, path)) names.push_back(name_of(*key));
  return names;
}

std::string_view nearest_key(Keys keys, std::string_view path) {
  const std::string_view name = path.substr(path.rfind('.') + 1);
  const auto nearest_among = [&](const std::vector<const Key*>& candidates) -> std::string_view {
    std::vector<std::string_view> names;
    for (const Key* key : candidates) names.push_back(name_of(*key));
    const std::string_view nearest = nearest_word(name, names);
    const auto found = std::ranges::find(candidates, nearest, [](const Key* key) { return name_of(*key); });
    return nearest.empty() ? "" : (*found)->path;
  };
  const std::string_view parent = parent_of(path);
  const std::vector<const Key*> siblings = keys_below(keys, parent);
  const std::string_view sibling = nearest_among(siblings);
  if (!sibling.empty()) return sibling;
  const bool must_agree = !parent.empty() && !siblings.empty();
  std::vector<const Key*> all;
  std::vector<std::string_view> paths;
  for (const Key& key : keys) {
    if (must_agree && name_of(key) != name) continue;
    all.push_back(&key);
    paths.push_back(key.path);
  }
  const std::string_view whole = nearest_word(path, paths);
  return whole.empty() ? nearest_among(all) : whole;
}

bool has_default(const Key& key) { return !key.without.empty() && !key.without.starts_with('('); }

bool is_required(Keys keys, const Key& key) {
  const Key* const parent = find_key(keys, parent_of(key.path));
  return key.without.empty() && (parent == nullptr || parent->kind != kOneOf);
}

Range range_of(const Key& key) {
  const std::string_view text = key.kind == kChoice ? "" : split(key.range, " | ").front();
  const std::vector<std::string_view> ends = split(text, " .. ");
  Range range;
  if (ends.size() == 2) {
    range.least_text = ends[0];
    range.most_text = ends[1];
  } else if (!text.empty()) {
    range.open = text.starts_with("> ");
    if (!range.open && !text.starts_with(">= ")) throw std::logic_error(fmt::format("range of {}", key.path));
    range.least_text = text.substr(range.open ? 2 : 3);
  }
  if (!range.least_text.empty()) range.least = bound(key, range.least_text);
  if (!range.most_text.empty()) range.most = bound(key, range.most_text);
  return range;
}

std::vector<std::string_view> words_of(const Key& key) {
  std::vector<std::string_view> words = split(key.range, " | ");
  if (key.kind != kChoice) words.erase(words.begin());  // the range of numbers, which may be empty
  return words;
}

std::string range_fault(const Key& key, double value, std::string_view text) {
  const Range range = range_of(key);
  if (range.open && value <= range.least) {
    return fmt::format("{} must be greater than {}", text, range.least == 0.0 ? "zero" : range.least_text);
  }
  if (range.most_text.empty() && range.least == 0.0 && value < 0.0) return fmt::format("{} must not be negative", text);
  if (value < range.least) return fmt::format("{} must be at least {}", text, range.least_text);
  if (value > range.most) return fmt::format("{} must be at most {}", text, range.most_text);
  return "";
}

}  // namespace thenar
