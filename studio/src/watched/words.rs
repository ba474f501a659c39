//! What a robot says of itself, in words.

use robot::FloorState;
use wire::{Floor, Place, PlaceState};

/// What a robot says of its place in its kept map.
pub fn place_words(place: &Place) -> String {
    let kept = format!("its kept map, number {}", place.sequence);
    match place.state {
        PlaceState::Fresh => {
            "It keeps no map yet: it saves one when it has mapped a room, or has driven for three metres and stands."
                .to_owned()
        }
        PlaceState::Searching => format!("It looks for itself in {kept}."),
        PlaceState::Probation => format!("It takes itself to be in {kept}, on probation."),
        PlaceState::Tracking => format!("It knows where it is in {kept}."),
        PlaceState::Doubtful => format!("Its readings contradict {kept}."),
    }
}

/// What a robot says of the floor that it sweeps.
pub fn floor_words(floor: &Floor) -> String {
    let doing = floor.state().map_or("something that this page does not know", FloorState::name);
    let (swept_m2, share, minutes) = (floor.swept_m2, 100.0 * floor.share(), f64::from(floor.seconds) / 60.0);
    format!("The floor: {doing}; {swept_m2:.1} m² swept, {share:.0} % of what it saw, in {minutes:.1} minutes.")
}
