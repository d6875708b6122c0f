//! Models written and read again.

use std::collections::BTreeMap;
use std::path::Path;

use lostmotion::drive::{CurrentSensor, LinkEncoder, Motor, Sensing, VelocitySensor};
use lostmotion::gearhead::{FrictionLaw, Lines};
use lostmotion::robot::{Coupling, EffectEntry, First, Load, Masses, Model};
use rand::RngExt;

use super::support::random;
use super::{MODEL, URDF, texts};

#[test]
fn equivalent_saved_models_load_as_they_were() {
    let mut rng = random(11);
    let mut number = |size: f64| 10_f64.powf(rng.random_range(-4.0..4.0)) * size;
    for case in 0..20 {
        let mut model = texts(MODEL, URDF).unwrap();
        for joint in &mut model.joints {
            joint.gear_ratio = number(1.0);
            joint.rotor_inertia = (case % 6 != 0).then(|| number(1e-5));
            joint.gear_stiffness = (case % 7 != 0).then(|| number(1e3));
            joint.gear_damping = (case % 8 != 0).then(|| number(1.0));
            joint.encoder = joint.encoder.filter(|_| case % 9 != 0);
            joint.backlash = (case % 3 != 0).then(|| number(1e-4));
            joint.motor = (case % 5 != 0).then(|| Motor {
                torque_constant: number(0.1),
                resistance: (case % 2 == 0).then(|| number(1.0)),
                inductance: (case % 4 == 0).then(|| number(1e-3)),
            });
            joint.amplifier.voltage_limit = if case % 5 == 0 { f64::INFINITY } else { number(10.0) };
            joint.velocity_sensor =
                [None, Some(VelocitySensor::PulsePeriod), Some(VelocitySensor::LowPass(0.02))][case % 3];
            joint.link_encoder = (case % 3 == 1).then(|| LinkEncoder { resolution: number(1e-6) });
            let sensing = if case % 2 == 0 { Sensing::Absolute } else { Sensing::Signed };
            joint.current_sensor = Some(CurrentSensor { noise: number(0.01), resolution: 0.0, sensing });
            if let (1, Some(friction)) = (case % 2, &mut joint.friction) {
                let lines = [0, 1].map(|_| {
                    let (a2, b2) = (number(1.0), number(1.0));
                    Lines { a1: a2 + number(1.0), b1: b2 - number(1.0), a2, b2 }
                });
                friction.law = FrictionLaw::TwoLines(lines);
            }
        }
        model.robot.gravity =
            nalgebra::Vector3::new(number(0.1), -number(0.1), if case % 2 == 0 { 0.0 } else { -9.81 });
        let row = nalgebra::DMatrix::from_row_slice(2, 2, &[1.0, 0.0, number(1.0), -number(1.0)]);
        model.robot.coupling = (case % 3 == 2).then(|| Coupling::new(row).unwrap());
        model.masses = if case % 2 == 0 { Masses::Known } else { Masses::Estimated };
        model.effects = vec![
            EffectEntry { effect: "payload".into(), joint: None, parameters: [("mass".into(), number(1.0))].into() },
            EffectEntry { effect: "cogging".into(), joint: Some("elbow".into()), parameters: [].into() },
        ];
        let position = [number(0.1), -number(0.1), 0.0];
        model.loads = vec![Load { session: "with a disc".into(), mass: number(1.0), position }];
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("model.toml");
        model.save(&file).unwrap();
        let again = Model::load(&file).unwrap();
        // The URDF was embedded, so it was written beside the model.
        assert_eq!(again.urdf, folder.path().join("elbow.urdf"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing half-written is left");
        assert_eq!(again, Model { source: file.clone(), urdf: again.urdf.clone(), ..model });
    }
}

#[test]
fn property_saved_models_find_their_urdf_again() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let model = Model::load(&root.join("robots/emps/model.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("out/model.toml");
    assert!(model.save(&file).is_err(), "the folder is not there");
    std::fs::create_dir(folder.path().join("out")).unwrap();
    model.save(&file).unwrap();
    let again = Model::load(&file).unwrap();
    assert_eq!(again.urdf, root.join("robots/emps/emps.urdf").canonicalize().unwrap());
    assert_eq!(again.robot, model.robot);
    // Beside its URDF the path is relative, so that the folder can move.
    let urdf = folder.path().join("out/emps.urdf");
    std::fs::write(&urdf, &model.urdf_text).unwrap();
    Model { urdf, ..model }.save(&file).unwrap();
    assert_eq!(Model::load(&file).unwrap().urdf, folder.path().join("out/emps.urdf"));
    assert!(std::fs::read_to_string(&file).unwrap().contains("urdf = \"emps.urdf\""));
}

#[test]
fn property_a_first_model_of_a_urdf_is_complete() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for urdf in ["robots/elbow/elbow.urdf", "robots/emps/emps.urdf"] {
        let model = First::of(&root.join(urdf), &BTreeMap::new()).unwrap().model;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("model.toml");
        model.save(&file).unwrap();
        let again = Model::load(&file).unwrap();
        assert_eq!(again.joints, model.joints);
        assert!(again.joints.iter().all(|joint| joint.friction.is_none() && joint.backlash.is_none()));
    }
}

#[test]
fn regress_an_embedded_urdf_is_written_over_no_other_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let model = Model::load(&root.join("robots/emps/model.toml")).unwrap();
    let embedded = Model { urdf: "gone/emps.urdf".into(), ..model };
    let folder = tempfile::tempdir().unwrap();
    let (file, urdf) = (folder.path().join("model.toml"), folder.path().join("emps.urdf"));
    std::fs::write(&urdf, "mine").unwrap();
    let error = embedded.save(&file).unwrap_err().to_string();
    assert!(error.contains("emps.urdf: expected no other file"), "{error}");
    assert_eq!(std::fs::read_to_string(&urdf).unwrap(), "mine");
    assert!(!file.exists());
    std::fs::remove_file(&urdf).unwrap();
    embedded.save(&file).unwrap();
    embedded.save(&file).unwrap();
    // A URDF that bears the name of the model file gets another.
    Model { urdf: "gone/model.toml".into(), ..embedded }.save(&file).unwrap();
    assert_eq!(Model::load(&file).unwrap().urdf, folder.path().join("robot.urdf"));
}
