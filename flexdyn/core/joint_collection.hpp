// The joints flexdyn has: a small Pinocchio joint collection, a third of the default's time to compile.
#pragma once

#include <pinocchio/multibody.hpp>

namespace flexdyn {

// Every arm is rebuilt from revolute (aligned or not) and prismatic joints; Pinocchio's checks ask for a mimic type.
template <typename S, int O>
struct JointCollection {
  typedef S Scalar;
  static constexpr int Options = O;

  typedef pinocchio::JointModelRevoluteTpl<S, O, 0> JointModelRX;
  typedef pinocchio::JointModelRevoluteTpl<S, O, 1> JointModelRY;
  typedef pinocchio::JointModelRevoluteTpl<S, O, 2> JointModelRZ;
  typedef pinocchio::JointModelRevoluteUnalignedTpl<S, O> JointModelRevoluteUnaligned;
  typedef pinocchio::JointModelPrismaticUnalignedTpl<S, O> JointModelPrismaticUnaligned;
  typedef pinocchio::JointModelMimicTpl<S, O, flexdyn::JointCollection> JointModelMimic;
  typedef pinocchio::JointModelCompositeTpl<S, O, flexdyn::JointCollection> JointModelComposite;
  typedef boost::variant<JointModelRX, JointModelRY, JointModelRZ, JointModelRevoluteUnaligned,
                         JointModelPrismaticUnaligned, boost::recursive_wrapper<JointModelMimic>>
      JointModelVariant;

  typedef pinocchio::JointDataRevoluteTpl<S, O, 0> JointDataRX;
  typedef pinocchio::JointDataRevoluteTpl<S, O, 1> JointDataRY;
  typedef pinocchio::JointDataRevoluteTpl<S, O, 2> JointDataRZ;
  typedef pinocchio::JointDataRevoluteUnalignedTpl<S, O> JointDataRevoluteUnaligned;
  typedef pinocchio::JointDataPrismaticUnalignedTpl<S, O> JointDataPrismaticUnaligned;
  typedef pinocchio::JointDataMimicTpl<S, O, flexdyn::JointCollection> JointDataMimic;
  typedef pinocchio::JointDataCompositeTpl<S, O, flexdyn::JointCollection> JointDataComposite;
  typedef boost::variant<JointDataRX, JointDataRY, JointDataRZ, JointDataRevoluteUnaligned,
                         JointDataPrismaticUnaligned, boost::recursive_wrapper<JointDataMimic>>
      JointDataVariant;
};

using Joints = JointCollection<double, 0>;
using Model = pinocchio::ModelTpl<double, 0, JointCollection>;
using Data = pinocchio::DataTpl<double, 0, JointCollection>;

}  // namespace flexdyn
