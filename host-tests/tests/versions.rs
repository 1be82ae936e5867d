//! The changelog tells the versions that the code has.

#[test]
fn the_changelog_has_every_version_apart() {
    let changelog = include_str!("../../CHANGELOG.md");
    for (what, version) in [
        ("release", env!("CARGO_PKG_VERSION").to_owned()),
        ("messages and configurations (`wire::VERSION`)", wire::VERSION.to_string()),
        ("messages of a joint (`wire::joint::JOINT_VERSION`)", wire::joint::JOINT_VERSION.to_string()),
        ("registers (`wire::registers::VERSION`)", wire::registers::VERSION.to_string()),
        ("storage on the board (`firmware::store::LAYOUT`)", firmware::store::LAYOUT.to_string()),
        (
            "storage on a joint's board (`firmware::store::JOINT_LAYOUT`)",
            firmware::store::JOINT_LAYOUT.to_string(),
        ),
        ("model files (`format`)", recording::model_file::FORMAT.to_string()),
        ("model files of joints (`format`)", recording::joint::file::FORMAT.to_string()),
        ("backups (`format`)", board_client::backup::FORMAT.to_string()),
        ("backups of joints' boards (`format`)", board_client::backup::JOINT_FORMAT.to_string()),
    ] {
        let row = format!("| {what} | {version} |");
        assert!(changelog.contains(&row), "the changelog lacks {row}");
    }
}
