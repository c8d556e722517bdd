//! x
use tests::toolchain::Firmware;
#[test]
fn scratch() {
    for f in [Firmware::audited("footprint"), Firmware::audited("spoiled"), Firmware::emulated("qemu-mission")] {
        println!("{:?}", f.build().unwrap());
    }
}
