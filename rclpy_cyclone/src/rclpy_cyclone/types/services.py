"""Definitions of the served services: name -> (request, response), in the ``.srv`` language."""

_PARAM = "rcl_interfaces/msg/"

# Default values other than zero, which the type store does not keep.
DEFAULTS: dict[str, dict[str, object]] = {
    "geometry_msgs/msg/Quaternion": {"w": 1.0},
    "sensor_msgs/msg/NavSatStatus": {"status": -2},
    "type_description_interfaces/srv/GetTypeDescription_Request": {"include_type_sources": True},
}

DEFINITIONS: dict[str, tuple[str, str]] = {
    "std_srvs/srv/Empty": ("", ""),
    "std_srvs/srv/SetBool": ("bool data", "bool success\nstring message"),
    "std_srvs/srv/Trigger": ("", "bool success\nstring message"),
    "rcl_interfaces/srv/DescribeParameters": (
        "string[] names",
        f"{_PARAM}ParameterDescriptor[] descriptors",
    ),
    "rcl_interfaces/srv/GetParameters": ("string[] names", f"{_PARAM}ParameterValue[] values"),
    "rcl_interfaces/srv/GetParameterTypes": ("string[] names", "uint8[] types"),
    "rcl_interfaces/srv/ListParameters": (
        "uint64 DEPTH_RECURSIVE=0\nstring[] prefixes\nuint64 depth",
        f"{_PARAM}ListParametersResult result",
    ),
    "rcl_interfaces/srv/SetParameters": (
        f"{_PARAM}Parameter[] parameters",
        f"{_PARAM}SetParametersResult[] results",
    ),
    "rcl_interfaces/srv/SetParametersAtomically": (
        f"{_PARAM}Parameter[] parameters",
        f"{_PARAM}SetParametersResult result",
    ),
    "rcl_interfaces/srv/GetLoggerLevels": ("string[] names", f"{_PARAM}LoggerLevel[] levels"),
    "rcl_interfaces/srv/SetLoggerLevels": (
        f"{_PARAM}LoggerLevel[] levels",
        f"{_PARAM}SetLoggerLevelsResult[] results",
    ),
    "type_description_interfaces/srv/GetTypeDescription": (
        "string type_name\nstring type_hash\nbool include_type_sources",
        "bool successful\nstring failure_reason\n"
        "type_description_interfaces/msg/TypeDescription type_description\n"
        "type_description_interfaces/msg/TypeSource[] type_sources\n"
        "type_description_interfaces/msg/KeyValue[] extra_information",
    ),
    "sensor_msgs/srv/SetCameraInfo": (
        "sensor_msgs/msg/CameraInfo camera_info",
        "bool success\nstring status_message",
    ),
    "diagnostic_msgs/srv/AddDiagnostics": (
        "string load_namespace",
        "bool success\nstring message",
    ),
    "diagnostic_msgs/srv/SelfTest": (
        "",
        "string id\nbyte passed\ndiagnostic_msgs/msg/DiagnosticStatus[] status",
    ),
    "nav_msgs/srv/GetMap": ("", "nav_msgs/msg/OccupancyGrid map"),
    "nav_msgs/srv/GetPlan": (
        "geometry_msgs/msg/PoseStamped start\ngeometry_msgs/msg/PoseStamped goal\n"
        "float32 tolerance",
        "nav_msgs/msg/Path plan",
    ),
    "nav_msgs/srv/LoadMap": (
        "string map_url",
        "uint8 RESULT_SUCCESS=0\nuint8 RESULT_MAP_DOES_NOT_EXIST=1\n"
        "uint8 RESULT_INVALID_MAP_DATA=2\nuint8 RESULT_INVALID_MAP_METADATA=3\n"
        "uint8 RESULT_UNDEFINED_FAILURE=255\n"
        "nav_msgs/msg/OccupancyGrid map\nuint8 result",
    ),
    "nav_msgs/srv/SetMap": (
        "nav_msgs/msg/OccupancyGrid map\ngeometry_msgs/msg/PoseWithCovarianceStamped initial_pose",
        "bool success",
    ),
    "visualization_msgs/srv/GetInteractiveMarkers": (
        "",
        "uint64 sequence_number\nvisualization_msgs/msg/InteractiveMarker[] markers",
    ),
    "action_msgs/srv/CancelGoal": (
        "action_msgs/msg/GoalInfo goal_info",
        "int8 ERROR_NONE=0\nint8 ERROR_REJECTED=1\nint8 ERROR_UNKNOWN_GOAL_ID=2\n"
        "int8 ERROR_GOAL_TERMINATED=3\n"
        "int8 return_code\naction_msgs/msg/GoalInfo[] goals_canceling",
    ),
    "lifecycle_msgs/srv/ChangeState": (
        "lifecycle_msgs/msg/Transition transition",
        "bool success",
    ),
    "lifecycle_msgs/srv/GetState": ("", "lifecycle_msgs/msg/State current_state"),
    "lifecycle_msgs/srv/GetAvailableStates": (
        "",
        "lifecycle_msgs/msg/State[] available_states",
    ),
    "lifecycle_msgs/srv/GetAvailableTransitions": (
        "",
        "lifecycle_msgs/msg/TransitionDescription[] available_transitions",
    ),
}
