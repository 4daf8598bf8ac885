"""The stages, in the order the data flows: each a pure module beside a thin LeafSystem.

=========== ============================ ============================================================= =======
stage       system                       ports                                                         rate
=========== ============================ ============================================================= =======
camera      camera.Camera                color_image, watching -> frame                                25 Hz
camera      room_light.RoomLight         color_image, light -> frame                                   25 Hz
skin        segmenter.SkinSegmenter      frame, hand_tracks -> regions                                 25 Hz
hands       tracker.HandTracker          regions -> hand_tracks                                        25 Hz
hands       track_points.TrackPoints     hand_tracks -> points                                         none held
hands       person_truth.PersonTruth     label_image -> hand_tracks_true                               25 Hz
gestures    recogniser.GestureRecogniser hand_tracks -> gesture                                        25 Hz
gestures    announcer.GestureAnnouncer   frame, regions, hand_tracks, gesture -> picture, understood,  none held
                                         answer
pose        (pure)                       points and pixels -> poses
calibration (pure)                       images, poses of the hand -> lens, X_WC, covariance
tracking    tracker.ModelTracker         frame, initial_pose, occluders -> object_pose                 25 Hz
tracking    annotator.PoseAnnotator      frame, object_pose -> picture                                 none held
tracking    geometric_sight              X_CO_true, X_CE_true -> object_pose, hand_pose (in place of   25 Hz
            .GeometricSight              camera and tracker, for thousands of runs)
servo       pose_delay.PoseDelay         object_pose -> delayed_pose                                   25 Hz
servo       controller.VisualServo       object_pose, hand_pose, joint_state -> V_WE_W, servo_error,   25 Hz
                                         status
arm         commander.ArmCommander       V_WE_W, motor_position -> desired_state, limited_by, status   100 Hz
arm         set_points                   set_points -> desired_state, desired_acceleration             500 Hz
            .SetPointInterpolator
arm         limit_use.LimitUse           desired_state -> limit_use                                    100 Hz
arm         encoders.JointEncoders       state -> joint_state                                          none held
hand        driver.HandDriver            motor_command, torque_limit, hand_state, joint_torque ->      200 Hz
                                         desired_state, motor_position, motor_count,
                                         motor_torque, clutch, finger_torque
grasping    task.PickTask                object_pose, joint_state, motor_position, motor_torque ->     50 Hz
                                         V_WE_W, motor_command, torque_limit, initial_pose, watching,
                                         phase, slip_seen
grasping    hand_over.HandOver           V_pick, pick_phase, pick_watching, V_place, servo_error,       50 Hz
                                         servo_status -> V_WE_W, phase, watching
recording   recorder.Recorder            one port a channel                                            25 Hz
truth       PoseTruth, TrackingError,    body_poses -> X_WO_true, X_WE_true, X_CO_true; errors         25 Hz
            AlignmentError, PlacementError,
            KinematicTruth
=========== ============================ ============================================================= =======

``signals`` holds every value that crosses an abstract port, ``se3`` rigid motions, ``errors`` the user's errors, ``timing`` the wall time.
"""
