//! scratch
use pushbelt_lab::variators::{variator, inputs};
use pushbelt::variator::settings::RingModel;
use pushbelt::variator::run::Variator;
fn main(){
  let film: f64 = std::env::args().nth(1).map_or(10.0, |x| x.parse().unwrap());
  let filmt: f64 = std::env::args().nth(2).map_or(6e-6, |x| x.parse().unwrap());
  for (model, mesh) in [(RingModel::Ale,1),(RingModel::Ale,2)] { 
  for (ratio,force,torque) in [(7.0/3.0,11.2e3,50.0),(7.0/3.0,11.2e3,30.0),(7.0/3.0,22.4e3,100.0),(1.0,6e3,50.0)] {
    print!("{model:?} x{mesh} {ratio:.2} {torque}: ");
    for rough in [1e-7,1.5e-7,2e-7,2.5e-7,3e-7,3.5e-7,4e-7,5e-7,6e-7,8e-7,1e-6] {
      let mut p=variator(model); p.initial.ratio=ratio; p.belt.roughness=rough; p.belt.film_force=film; p.belt.film_thickness=filmt; p.mesh=p.mesh.refined(mesh);
      let mut v=Variator::new(p).unwrap();
      v.initialise(0.0,&inputs((torque,force),(-torque*ratio,force))).unwrap();
      let o=v.outputs(); print!(" {:.2}%/{:.3}",100.0*o.slip,o.thrust_ratio);
    } println!();
  }}
}
