"""URDFs of small serial arms as their makers would write them, standing on their first link."""

AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
INERTIAL = """<inertial><origin xyz="0 0 {centre}"/><mass value="{mass}"/>
<inertia ixx="{across}" iyy="{across}" izz="{along}" ixy="0" ixz="0" iyz="0"/></inertial>"""
LIMIT = '<limit lower="-2.6" upper="2.6" effort="{effort}" velocity="3"/>'


def serial_arm(
    axes: str, length: float = 0.12, mass: float = 0.2, effort: float = 6.0, **options: object
) -> str:
    """Returns the URDF of an arm that points up at zero.

    Args:
        axes: One letter for each joint.
        length, mass: m and kg, of each link, a rod along z.
        effort: N m, of each joint.
        options: `kind` of the joints; `offset` in m of each joint along x; `end`, elements of
            links and joints after the last link, which is named as `link_N` with N joints.
    """
    kind, offset = options.get("kind", "revolute"), options.get("offset", 0.0)
    inertial = INERTIAL.format(
        centre=length / 2, mass=mass, across=mass * length**2 / 12, along=mass * 1e-4
    )
    shape = f'<origin xyz="0 0 {length / 2}"/><geometry><box size="0.03 0.03 {0.8 * length}"/>'
    body = f"{inertial}<collision>{shape}</geometry></collision>"
    parts = [f'<link name="link_{i}">{body}</link>' for i in range(len(axes) + 1)]
    for i, axis in enumerate(axes, start=1):
        parts.append(
            f'<joint name="joint_{i}" type="{kind}"><parent link="link_{i - 1}"/>'
            f'<child link="link_{i}"/><origin xyz="{offset} 0 {length}"/>'
            f'<axis xyz="{AXES[axis]}"/>{LIMIT.format(effort=effort)}</joint>'
        )
    return f'<robot name="arm">{"".join(parts)}{options.get("end", "")}</robot>'


def frame_link(name: str, parent: str, xyz: str = "0 0 0.12", joint: str = "fixed") -> str:
    """Returns a link without mass and the joint above it, which turns about z if it moves."""
    return f"""<link name="{name}"/><joint name="{name}_joint" type="{joint}">
    <parent link="{parent}"/><child link="{name}"/><origin xyz="{xyz}"/><axis xyz="0 0 1"/>
    {LIMIT.format(effort=1)}</joint>"""
